"""``brickpose map``: a drive is recorded, mapped, and localized in the map that it drew."""

from contextlib import suppress
from pathlib import Path

import laser_office
import numpy as np
import pytest
from engine_runs import EIGHT
from recordings import record

from app.command_line import main
from app.engine.build import build_program
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.settings.config import Config
from robot.description.profile import load_profile
from robot.description.unknowns import NAMES
from robot.estimation import fit_quality
from robot.estimation.fit_quality import FitQuality
from robot.fields.field_loading import load_field
from robot.fields.grid_map import load_map_yaml
from robot.interface import RobotError
from robot.localization.estimate import State

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A lap of the figure-eight on the square."""
    return lap(tmp_path_factory.mktemp("lap"), 61, 16.5)


def lap(folder: Path, seed: int, seconds: float, **settings: str) -> Path:
    program = build_program(Config(robot="sim", seed=seed, **settings))
    try:
        made, _, _ = record(program, folder, seconds, EIGHT)
    finally:
        program.robot.close()
    return made


def test_a_recorded_drive_becomes_a_field_to_localize_in(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "floor.svg"
    assert main(["map", str(recording), "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "4 strokes of tape" in shown
    assert f"brickpose run --map {out}" in shown
    own, truth = load_field(str(out), tmp_path), load_field("square", Path("maps"))
    np.testing.assert_allclose(own.drive_area, truth.drive_area, atol=0.003)
    page = (tmp_path / "floor.html").read_text(encoding="utf-8")
    assert "It explains what the robot saw" in page
    grid = load_field(str(tmp_path / "floor.yaml"), tmp_path)
    assert grid.grid is not None
    # Another robot's drive on the true floor is localized in the map.
    program = open_replay(lap(tmp_path, 62, 8.0), ReplayOptions(map=str(out)))
    snapshots = []
    with suppress(RobotError):  # the recording is over
        while True:
            snapshots.append(program.engine.step())
    program.robot.close()
    last = snapshots[-2]
    assert last.integrity.state is State.CERTAIN
    assert last.pose is not None
    assert last.reading.truth is not None
    assert last.pose.distance_to(last.reading.truth) < 0.002


def test_white_tape_is_found_and_drawn_white(tmp_path: Path) -> None:
    text = Path("maps/square.svg").read_text("utf-8")
    floor, out = tmp_path / "white.svg", tmp_path / "drawn.svg"
    floor.write_text(text.replace("#202225", "#f2f2ee").replace("#d7d5cf", "#33363a"), "utf-8")
    made = lap(tmp_path, 63, 6.0, map=str(floor))
    assert main(["map", str(made), "--out", str(out)]) == 0
    assert [kind.light for kind in load_field(str(out), tmp_path).tape] == [True]
    assert main(["map", str(made), "--out", str(out), "--force", "--brightness", "dark"]) == 1


def test_a_clock_that_does_not_exist_is_refused(tmp_path: Path, capsys) -> None:
    bag = laser_office.write_bag(tmp_path / "office.mcap")
    assert main(["map", str(bag), "--clock", "wall", "--out", str(tmp_path / "floor.yaml")]) == 2
    assert "--clock is 'wall'; valid are header, log" in capsys.readouterr().err


def test_a_robot_is_calibrated_along_with_the_map(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, profile = tmp_path / "floor.svg", tmp_path / "robot.toml"
    arguments = ["map", str(recording), "--out", str(out), "--calibrate", str(profile)]
    out.with_suffix(".yaml").write_text("precious")
    assert main([*arguments, "--force"]) == 0
    shown = capsys.readouterr().out
    assert f"brickpose run --map {out} --profile {profile}" in shown
    assert "camera_pitch" in shown
    own, truth = load_field(str(out), tmp_path), load_field("square", Path("maps"))
    np.testing.assert_allclose(own.drive_area, truth.drive_area, atol=0.004)
    measured = load_profile(profile)
    assert abs(measured.values[NAMES.index("camera_pitch")]) < 0.002


def test_a_robot_that_cannot_be_built_so_gets_no_profile(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch
) -> None:
    monkeypatch.setattr(fit_quality, "MOST_PRIOR_SD", 1e-6)
    out, profile = tmp_path / "floor.svg", tmp_path / "robot.toml"
    arguments = ["map", str(recording), "--out", str(out), "--calibrate", str(profile)]
    assert main(arguments) == 1
    shown = capsys.readouterr()
    assert "its scale too, may be wrong" in shown.out
    assert "the result contradicts itself, so it is not kept" in shown.err
    assert out.with_suffix(".html").exists()
    assert not (profile.exists() or out.exists() or out.with_suffix(".yaml").exists())
    # Who insists gets both, which say so as data.
    assert main([*arguments, "--force"]) == 1
    assert FitQuality.of_table(load_profile(profile).fit).overrun
    assert "data-fit" in out.read_text("utf-8")


def test_a_recording_without_pictures_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = build_program(Config(robot="kinematic", seed=61))
    try:
        folder, _, _ = record(program, tmp_path, 2.0, EIGHT, picture_rate=0.01)
    finally:
        program.robot.close()
    assert main(["map", str(folder), "--out", str(tmp_path / "none.svg")]) == 1
    assert "no picture" in capsys.readouterr().err
    assert not (tmp_path / "none.svg").exists()


def test_particles_draw_the_same_floor_in_cells(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "floor.yaml"
    assert main(["map", str(recording), "--method", "grid", "--out", str(out)]) == 0
    assert f"the map is {out}" in capsys.readouterr().out
    grid = load_map_yaml(out)
    places = grid.origin.apply((np.argwhere(grid.occupied)[:, ::-1] + 0.5) * grid.resolution)
    # Of the tape's centre lines, 1 m apart, and 50 mm wide.
    aside = np.abs(np.abs(places).max(axis=1) - 0.5)
    assert np.quantile(aside, 0.9) < 0.025 + 0.03
    assert 0.6 < len(places) * grid.resolution**2 / (4 * 0.05) < 1.5
    assert load_field(str(out), tmp_path).grid is not None
