"""A camera that is bumped while the robot drives is told, measured anew, and not before."""

import math
from dataclasses import replace

import numpy as np
import pytest
from calibrations import SPEC, SQUARE

from app.engine.build import build_program
from app.messages.commands import SetCalibrationCommand
from app.messages.driving_commands import FigureEightCommand
from app.settings.conditions import apply_condition
from app.settings.config import Config, with_settings
from robot.calibration.drift import DriftFinding, Known
from robot.calibration.tracker import CalibrationTracker, camera_remark
from robot.description.unknowns import COUNT, NAMES, PRIORS
from robot.geometry import Array
from robot.scanning.line_scanner import LineScannerSettings
from sim.imperfections import BUMPS, Imperfections, bumped

BUMP_S = 14.0
EIGHT = FigureEightCommand(type="figure_eight")


def tracked(condition: str, seconds: float, seed: int = 3) -> tuple[list, list[tuple]]:
    """Calibrations that were taken over, and (stamp, error [m], alerts) of each tick."""
    config = apply_condition(Config(robot="sim", seed=seed), condition)
    config = with_settings(
        config, {"sim.imperfections.bump_time": BUMP_S, "sim.camera.frame_rate": 10.0}
    )
    program = build_program(replace(config, added={"calibration": {"track": True}}))
    changes, ticks = [], []
    try:
        while not ticks or ticks[-1][0] < seconds:
            program.engine.commands.put(EIGHT)
            snapshot = program.engine.step()
            changes += [
                (snapshot.stamp, command.values)
                for command in snapshot.commands
                if isinstance(command, SetCalibrationCommand)
            ]
            assert snapshot.truth is not None
            pose = snapshot.pose or snapshot.odometry
            alerts = [alert.text for alert in snapshot.integrity.alerts]
            ticks.append((snapshot.stamp, pose.distance_to(snapshot.truth), alerts))
    finally:
        program.robot.close()
    return changes, ticks


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "words", "settled"),
    [("pitch", "1.0° lower", 10.0), ("yaw", "further to the left", 17.0)],
)
def test_a_bumped_camera_is_told_and_measured_anew(axis: str, words: str, settled: float) -> None:
    changes, ticks = tracked(f"bumped-{axis}", BUMP_S + settled + 3)
    told = [
        stamp for stamp, _, alerts in ticks if any(f"{words} than calibrated" in a for a in alerts)
    ]
    # The first check after the bump, 0.7 s later, has three pictures of the moved camera: whether
    # they tell its direction is a matter of last digits. 25 pictures tell it, after 4.8 s more.
    assert told and BUMP_S < told[0] < BUMP_S + 28 * 0.2
    stamp, values = next(change for change in changes if change[0] > told[0])
    assert stamp < BUMP_S + 12
    assert math.degrees(values[f"camera_{axis}"]) == pytest.approx(1.0, abs=0.15)
    after = [error for when, error, _ in ticks if when > BUMP_S + settled]
    assert np.sqrt(np.mean(np.square(after))) < 0.001


@pytest.mark.slow
def test_a_robot_that_stays_as_it_is_stays_calibrated() -> None:
    changes, ticks = tracked("default", 12)
    assert not [alerts for _, _, alerts in ticks if alerts]
    for _, values in changes:  # small drifts may be learnt, within what nobody sees
        assert abs(math.degrees(values["camera_pitch"])) < 0.05
    assert np.sqrt(np.mean(np.square([error for when, error, _ in ticks if when > 2]))) < 0.0008


@pytest.mark.parametrize("axis", BUMPS[1:])
def test_a_remark_names_how_the_camera_looks(axis: str) -> None:
    before = SPEC.robot_from_camera[:3, :3]
    after = bumped(SPEC, Imperfections(bump=axis)).robot_from_camera[:3, :3]
    shift = np.zeros(3)
    shift[BUMPS.index(axis) - 1] = math.radians(1.0)
    ahead = after[:, 2] - before[:, 2]  # how the optical axis moves over the robot's axes
    words = camera_remark(shift)
    assert ("lower" in words) == (axis == "pitch" and ahead[2] < 0)
    assert ("left" in words) == (axis == "yaw" and ahead[1] > 0)
    right_edge = after[:, 0] - before[:, 0]
    assert ("more tilted to the right" in words) == (axis == "roll" and right_edge[2] < 0)


def finding(shift: Array, share: float = 1.0) -> DriftFinding:
    prior = Known(np.zeros(COUNT), np.diag((0.1 * PRIORS) ** 2))
    loose = prior.loosened(0.0)
    values = np.zeros(COUNT)
    values[:3] = shift
    seen = Known(values, np.diag((0.01 * PRIORS) ** 2))
    return DriftFinding(np.zeros((25, 3)), seen, prior, loose, np.eye(3), share, 1.0)


def test_a_window_that_does_not_fit_says_nothing() -> None:
    tracker = CalibrationTracker(SPEC, SQUARE, LineScannerSettings())
    assert tracker.take(finding(np.array([0.0, 0.02, 0.0]), share=0.4)) is None
    assert tracker.take(None) is None
    assert tracker.remark == ""


def test_what_was_known_counts_in_what_is_learnt() -> None:
    result = finding(np.array([0.0, 1e-4, 0.0])).tight
    pitch = NAMES.index("camera_pitch")
    assert 0 < result.values[pitch] <= 1e-4
    assert (np.diag(result.covariance) <= (0.0101 * PRIORS) ** 2).all()
