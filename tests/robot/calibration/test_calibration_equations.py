"""The equations of the calibration: their derivatives, and their solution."""

from __future__ import annotations

import numpy as np
import pytest
from calibrations import HAND_BUILT, SEED, SPEC, SQUARE, START_COVARIANCE, driven

from robot.calibration.adjustment import Adjustment, DriveEstimate, Weights
from robot.calibration.misses import Misses, misses
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import WheelMotion
from robot.description.unknowns import COUNT, NAMES, Differences
from robot.geometry import Array, Pose2


def of_drive(count: int) -> tuple[Sightings, WheelMotion, Array, Array]:
    log, true, path = driven(HAND_BUILT, SEED, 18.0)
    part = log.until(count)
    return Sightings.of(part, SPEC, SQUARE), WheelMotion.of(part, SPEC), true, path[:count]


def missed(seen: Sightings, motion: WheelMotion, values: Array, path: Array) -> Misses:
    floor = seen.floor_points(values, motion.twists(values))
    return misses(seen, floor, path, values, 0.05)


@pytest.mark.slow
def test_at_the_truth_edges_lie_where_they_should() -> None:
    found = missed(*of_drive(200))
    assert len(found.residuals) > 8000
    assert abs(np.mean(found.metres)) < 0.0001
    assert 0.3 < np.std(found.residuals) < 0.8  # twice the noise of one ray is assumed


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if "radius" not in name])
def test_derivatives_of_sightings_are_those_of_small_differences(name: str) -> None:
    seen, motion, true, path = of_drive(40)
    place, small = NAMES.index(name), 1e-5
    # Where the robot stands, the wheels tell nothing of a picture's rows.
    motion = WheelMotion(
        motion.stamps, motion.wheel_stamps, 0 * motion.wheel_angles, motion.radii, motion.separation
    )
    true = np.where(np.arange(COUNT) < 3, 0.0, true)  # rotation vectors add up only near zero
    now = missed(seen, motion, true, path)
    either = [missed(seen, motion, true + sign * small * np.eye(COUNT)[place], path)
              for sign in (1, -1)]  # fmt: skip
    assert all(np.array_equal(item.picture, now.picture) for item in either)
    slopes = (either[0].metres - either[1].metres) / (2 * small)
    sd = now.metres / now.residuals
    assert slopes == pytest.approx(now.by_unknowns[:, place] * sd, abs=2e-3)


def test_derivatives_of_steps_are_those_of_small_differences() -> None:
    seen, motion, true, path = of_drive(100)
    adjustment = Adjustment(seen, motion, path[0], START_COVARIANCE)
    slip = np.random.default_rng(0).normal(0, 0.03, (len(path), 2))
    state = DriveEstimate(true, path, slip)
    error, own, following, robot = adjustment._step_errors(state)
    small = 1e-6
    for column in range(3):
        poses = path.copy()
        poses[::2, column] += small
        change = (adjustment._step_errors(DriveEstimate(true, poses, slip))[0] - error) / small
        expected = np.where(
            (np.arange(len(error)) % 2 == 0)[:, None], own[:, :, column], following[:, :, column]
        )
        assert change == pytest.approx(expected, rel=1e-3, abs=1e-2)
    # Those by the wheels and their slip are taken at how the robot moved, so the path has to be
    # what they rolled.
    slip = np.zeros((len(path), 2))
    rolled = DriveEstimate(true, rolled_path(path[0], motion.steps(true, slip[:-1])[0]), slip)
    error, own, _, robot = adjustment._step_errors(rolled)
    for wheel in range(2):
        slips = slip.copy()
        slips[:, wheel] += small
        slipping = DriveEstimate(true, rolled.poses, slips)
        change = (adjustment._step_errors(slipping)[0] - error) / small
        assert change == pytest.approx(own[:, :, 3 + wheel], rel=1e-3, abs=1e-2)
    assert np.abs(error).max() < 1e-6
    for name in ("left_radius", "right_radius", "wheel_separation"):
        place = NAMES.index(name)
        values = true + small * np.eye(COUNT)[place]
        change = adjustment._step_errors(DriveEstimate(values, rolled.poses, slip))[0] / small
        assert change == pytest.approx(robot[:, :, place], rel=1e-2, abs=0.1)


def rolled_path(start: Array, steps: Array) -> Array:
    poses = [Pose2(*start.tolist())]
    for step in steps.tolist():
        poses.append(poses[-1] @ Pose2(*step))
    return np.array([pose.to_array() for pose in poses])


def test_banded_equations_are_solved_as_full_ones_are() -> None:
    seen, motion, true, path = of_drive(12)
    adjustment = Adjustment(seen, motion, path[0], START_COVARIANCE)
    equations = adjustment._equations(DriveEstimate(true, path, np.zeros((12, 2))), Weights(), None)
    size = 12 * 5
    full = np.zeros((size + COUNT, size + COUNT))
    for k in range(12):
        here = slice(5 * k, 5 * k + 5)
        full[here, here] = equations._own[k]
        full[here, size:] = equations._shared[k]
        full[size:, here] = equations._shared[k].T
        if k < 11:
            after = slice(5 * k + 5, 5 * k + 10)
            full[here, after] = equations._next[k]
            full[after, here] = equations._next[k].T
    full[size:, size:] = equations._robot
    right = np.concatenate([equations._right.reshape(-1), equations._robot_right])
    expected = np.linalg.solve(full, right)
    step, robot, covariance, pose_covariance = equations.solve()
    assert step.reshape(-1) == pytest.approx(expected[:size], rel=1e-5, abs=1e-9)
    assert robot == pytest.approx(expected[size:], rel=1e-5, abs=1e-9)
    inverse = np.linalg.inv(full)
    assert covariance == pytest.approx(inverse[size:, size:], rel=1e-4, abs=1e-12)
    assert pose_covariance == pytest.approx(inverse[55:58, 55:58], rel=1e-4, abs=1e-12)


def test_differences_are_applied_and_found_again() -> None:
    values = np.array([0.01, -0.02, 0.005, 0.002, -0.003, 0.001, 0.02, 0.04, 0.01, -0.02, 0.03])
    built = Differences(values).applied_to(SPEC)
    assert built.picture_delay == 0.04
    assert built.as_drawn is SPEC
    again = Differences.between(SPEC, built, built.picture_delay).values
    assert again == pytest.approx(values, abs=1e-12)
