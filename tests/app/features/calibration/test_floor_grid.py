"""The floor's grid lies on the floor, every 0.1 m."""

from __future__ import annotations

import numpy as np
import pytest
from engine_runs import kinematic, run

from app.features.calibration.floor_grid import floor_grid_router
from robot.calibration.mounting.floor_grid import grid_labels, grid_lines
from robot.camera import FloorView
from robot.description.spec import RobotSpec
from robot.geometry import Array


@pytest.fixture(scope="module")
def view() -> FloorView:
    return RobotSpec.load().floor_view


def test_each_line_lies_on_the_floor_where_it_should(view: FloorView) -> None:
    lines = list(grid_lines(view))
    marks = set()
    for line in lines:
        assert len(line.pixels) > 1 and view.inside(line.pixels, -20).all()
        floor = view.floor_points(line.pixels)
        steady = int(np.argmin(np.ptp(floor, axis=0)))
        mark = floor[:, steady].mean()
        assert np.abs(floor[:, steady] - mark).max() < 1e-6
        assert abs(10 * mark - round(10 * mark)) < 1e-5
        assert line.ahead == (steady == 1 and abs(mark) < 1e-6)
        assert (np.diff(floor[:, 1 - steady]) > 0).all()  # one piece, in order
        marks.add((steady, round(10 * mark)))
    assert {(1, -1), (1, 0), (1, 1), (0, 2), (0, 3)} <= marks


def test_distances_stand_on_the_line_straight_ahead(view: FloorView) -> None:
    labels = grid_labels(view)
    assert len(labels) >= 3
    for distance, pixel in labels:
        assert view.floor_points(pixel[None])[0] == pytest.approx((distance, 0), abs=1e-6)
        assert view.inside(pixel[None])[0]


def raised(spec: RobotSpec) -> Array:
    """Where the camera sits if it sits 5 mm higher."""
    pose = spec.robot_from_camera.copy()
    pose[2, 3] += 0.005
    return pose


def test_the_page_gets_the_grid_of_the_present_calibration() -> None:
    program = kinematic()
    run(program, 0.1)
    (route,) = floor_grid_router(program).routes
    drawn = route.endpoint()  # type: ignore[attr-defined]
    assert sum(line.ahead for line in drawn.lines) == 1
    controls = program.engine.controls
    controls.spec = controls.spec.with_camera(controls.spec.lens, raised(controls.spec))
    run(program, 0.1)
    assert route.endpoint() != drawn  # type: ignore[attr-defined]
    view = program.engine.spec.floor_view
    label = route.endpoint().labels[0]  # type: ignore[attr-defined]
    place = view.floor_points(np.array([[label.u, label.v]]))[0]
    assert place == pytest.approx((label.distance, 0), abs=1e-6)
