"""Tape that is lighter than the floor is drawn as such."""

from pathlib import Path

import numpy as np
import pytest
from mappings import WIDTH, errors_of, field_of, mapped

from app.engine.build import load_field
from app.settings.config import MAPS
from robot.calibration.drive_log import DriveRecorder
from robot.description.spec import RobotSpec
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2, Twist2
from robot.mapping.drawing import drawing
from robot.mapping.ends import RaysOnFloor
from robot.mapping.shades import shaded
from robot.mapping.strokes import Stroke
from robot.mapping.tidying import TidyStrokes
from robot.scanning.line_scanner import LineScannerSettings
from robot.scanning.tape import Tape
from sim.floor_camera import CameraSettings, FloorCamera

STROKES = tuple(
    Stroke(np.array([[-0.4, y], [0.4, y]]), light=light)
    for y, light in ((0.3, True), (-0.3, False))
)


def white(folder: Path, name: str) -> str:
    """The file of a field of ours in white on a dark floor."""
    text = (MAPS / f"{name}.svg").read_text("utf-8")
    path = folder / f"white-{name}.svg"
    path.write_text(text.replace("#202225", "#f2f2ee").replace("#d7d5cf", "#33363a"), "utf-8")
    return str(path)


@pytest.mark.parametrize(
    "chosen", [STROKES, STROKES[:1], STROKES[1:]], ids=["both", "light", "dark"]
)
def test_a_drawing_has_the_shades_of_its_tape(chosen: tuple[Stroke, ...]) -> None:
    path = np.array([[*chosen[0].nodes[0], 0.0]])
    field = field_of_drawing(drawing(TidyStrokes(chosen, (), {}), WIDTH, path, "Shades"), "own")
    assert {kind.light for kind in field.tape} == {stroke.light for stroke in chosen}
    assert len(field.edges) == 4 * len(chosen)


def test_a_stroke_has_the_shade_that_most_rays_saw() -> None:
    x = np.repeat(np.linspace(-0.3, 0.3, 30), 2)
    entry = np.column_stack([x, np.tile([0.275, -0.325], 30)])
    light = np.tile([True, False], 30)
    light[:8] = ~light[:8]
    nothing = np.full_like(entry, np.nan)
    leaving = entry + np.array([0.0, 0.05])
    rays = RaysOnFloor(
        nothing, nothing, entry, leaving, entry, leaving, np.zeros(60, np.intp), light
    )
    unseen = Stroke(np.array([[1.0, 0.0], [1.0, 1.0]]))
    plain = TidyStrokes((Stroke(STROKES[0].nodes), Stroke(STROKES[1].nodes), unseen), (), {})
    assert [stroke.light for stroke in shaded(plain, WIDTH, rays).strokes] == [True, False, False]


def test_a_scanner_of_both_shades_tells_which_it_saw() -> None:
    path = np.zeros((1, 3))
    field = field_of_drawing(drawing(TidyStrokes(STROKES, (), {}), WIDTH, path, "Both"), "own")
    spec = RobotSpec.load()
    settings = LineScannerSettings(tape_brightness="either")
    recorder = DriveRecorder(spec, settings, (Tape(WIDTH),), calibrated=True)
    camera = FloorCamera(spec.floor_view, field.floor, CameraSettings(), np.random.default_rng(1))
    for turn, light in ((1, True), (-1, False)):
        pose = Pose2(0.0, 0.0, turn * np.pi / 2)
        picture = camera.picture(pose, Twist2())
        edges, _, lighter = recorder._edges(picture)
        seen = np.isfinite(edges[: len(lighter), 0])
        assert seen.sum() > 10
        assert (lighter[seen] == light).all()


@pytest.mark.slow
def test_white_tape_is_drawn_as_well_as_black(tmp_path: Path) -> None:
    name = white(tmp_path, "stub")
    drawn, poses = mapped(name, 9301)
    errors = errors_of(drawn, poses, load_field(name, MAPS))
    assert errors.mean < 0.0005
    assert errors.covered > 0.99
    assert drawn.fits
    assert drawn.remarks == ()
    field = field_of(drawn)
    assert all(kind.light for kind in field.tape)
    assert np.median(field.floor.image) < 128
