"""What the 3D view's nodes hold; how they look is for the browser's tests."""

from dataclasses import replace

import numpy as np
import pytest

from app.engine.build import build_program
from app.features.mapping.map_layer import MapLayer
from app.page.view.camera_layer import CELL
from app.page.view.marks import ESTIMATE, hypothesis_mark
from app.page.view.scene import FAR_AWAY, HIT, ODOMETRY, RAY, TRUTH
from app.page.view.view import View
from app.settings.config import FRONTEND, MAPS, Config
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud
from robot.mapping.sketch import Sketch


@pytest.fixture(scope="module")
def shown():
    program = build_program(Config(robot="kinematic"))
    for _ in range(10):
        snapshot = program.engine.step()
    view = View(program.field, program.robot.spec, program.engine.latest)
    yield view._scene, snapshot
    view.close()


def with_places(snapshot, *weights):
    places = [Hypothesis(w, Pose2(0.1 * i, 0, i), 1e-4 * np.eye(3)) for i, w in enumerate(weights)]
    # Nodes follow measurements: a new one is a new object.
    estimate = replace(snapshot.estimate, hypotheses=tuple(places))
    return replace(scanned_anew(snapshot), estimate=estimate)


def scanned_anew(snapshot, **changes):
    """The same with another scan of the same content, which the scene draws again."""
    line_scan = replace(snapshot.filter.line_scan)
    return replace(snapshot, filter=replace(snapshot.filter, line_scan=line_scan, **changes))


def test_each_likely_place_has_its_ellipse(shown):
    scene, snapshot = shown
    one = len(hypothesis_mark(Pose2(), np.eye(3)))
    for weights, count in (((1.0,), 1), ((0.5, 0.3, 0.19, 0.01), 3)):
        scene.update(with_places(snapshot, *weights))
        node = scene._nodes["covariance"]
        assert len(node.points) == len(node.colors) == count * one


def test_the_likeliest_place_has_the_fullest_colour(shown):
    scene, snapshot = shown
    scene.update(with_places(snapshot, 0.7, 0.3))
    colours = scene._nodes["covariance"].colors.astype(int).sum(axis=(1, 2))
    assert colours[0] < colours[-1]


def test_what_is_not_known_is_not_shown(shown):
    scene, snapshot = shown
    nothing = Cloud(np.empty((0, 3)), np.empty(0))
    scene.update(with_places(snapshot, 1.0))
    scene.update(
        replace(scanned_anew(snapshot, cloud=nothing), pose=None, estimate=None, scan_pose=None)
    )
    for name in ("covariance", "rays", "hits"):
        assert np.all(scene._nodes[name].points == FAR_AWAY)
    assert scene._believed.position[2] == FAR_AWAY
    assert np.all(scene._nodes["particles"].points[:, :2] == FAR_AWAY)
    scene.update(scanned_anew(snapshot))
    assert np.abs(scene._nodes["rays"].points).max() < 5


def test_rays_and_outline_move_with_the_robot_in_one_node(shown):
    scene, snapshot = shown
    moved = snapshot.pose @ Pose2(0.1, 0, 0.2)
    scene.update(replace(scanned_anew(snapshot), pose=moved))
    assert scene._believed.position[:2] == pytest.approx((moved.x, moved.y))
    assert scene._nodes["rays"].name.startswith("/believed/")
    assert scene._nodes["estimate"].name.startswith("/believed/")
    # The hits stay where they are on the floor, wherever the robot has gone since the picture.
    hits = moved.apply(np.asarray(scene._nodes["hits"].points, float)[:, :2])
    seen = snapshot.scan_pose.apply(snapshot.filter.line_scan.scan.points())
    assert hits == pytest.approx(seen, abs=1e-3)


def test_the_cameras_picture_stands_in_its_frustum_and_lies_on_the_floor(shown):
    scene, snapshot = shown
    for _ in range(6):
        scene.update(snapshot)
    camera = scene._camera
    picture = camera._frustum.image
    assert picture.shape == (120, 160, 3)
    assert abs(int(picture.mean()) - int(snapshot.frame.image.mean())) < 5
    # Each point of it is where the floor's drawing has it.
    floor = camera._floor.image
    rows, columns = np.mgrid[: floor.shape[0], : floor.shape[1]].reshape(2, -1)
    there = camera._patch.middle + CELL * np.column_stack(
        [columns - (floor.shape[1] - 1) / 2, rows - (floor.shape[0] - 1) / 2]
    )
    drawn = drawn_at(scene_field(), snapshot.truth.apply(there))
    seen = floor[rows, columns, 0]
    tape, bare = drawn < 60, drawn > 150
    assert tape.sum() > 100
    assert np.median(seen[tape]) < 80
    assert np.median(seen[bare]) > 120
    assert (seen[tape] < 100).mean() > 0.9
    # As the robot moves on, the picture stays where it was taken.
    moved = snapshot.pose @ Pose2(0.05, 0.02, 0.3)
    scene.update(replace(snapshot, pose=moved))
    x, y, _ = camera._floor.position
    assert moved.apply(np.array([[x, y]])) == pytest.approx(
        snapshot.scan_pose.apply(camera._patch.middle[None]), abs=1e-6
    )


def scene_field():
    return load_field(Config().map, MAPS)


def drawn_at(field, points):
    picture, (xmin, _, _, ymax) = field.floor.image, field.floor.extent
    columns = np.rint((points[:, 0] - xmin) / field.floor.resolution - 0.5).astype(int)
    rows = np.rint((ymax - points[:, 1]) / field.floor.resolution - 0.5).astype(int)
    return picture[rows.clip(0, len(picture) - 1), columns.clip(0, picture.shape[1] - 1)]


def test_colours_are_those_of_the_map():
    styles = (FRONTEND / "style" / "tokens.css").read_text()
    for name, colour in (
        ("truth", TRUTH), ("odometry", ODOMETRY), ("estimate", ESTIMATE), ("rays", RAY),
        ("hits", HIT),
    ):  # fmt: skip
        assert f"--floor-{name}: #{bytes(colour).hex()};" in styles


def test_the_map_that_is_drawn_is_shown_with_its_corrections(shown):
    scene, _ = shown
    line = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.4]])
    path = np.column_stack([np.linspace(0, 0.4, 9), np.zeros((9, 2))])
    first = Sketch((line,), np.array([0.003]), path, line, 1.0, None)
    moved = path.copy()
    moved[-3:, 1] += 0.02
    second = replace(first, path=moved)
    layer = MapLayer(scene._server.scene, iter([None, first, second, None]).__next__)
    layer.update()
    assert not layer._lines["tape"].visible
    layer.update()
    assert layer._lines["tape"].points[:, :, :2] == pytest.approx(_pairs(line))
    assert len(layer._lines["band"].points) == 4
    assert not layer._lines["correction"].visible
    layer.update()
    assert layer._lines["correction"].visible
    corrections = layer._lines["correction"].points[:, :, 1]
    assert corrections == pytest.approx(np.tile([0.0, 0.02], (3, 1)))
    layer.update()
    assert not any(node.visible for node in (*layer._lines.values(), *layer._points.values()))


def _pairs(line):
    return np.stack([line[:-1], line[1:]], axis=1)
