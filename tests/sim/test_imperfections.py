"""What real robots have and their description does not say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Pose2, Twist2
from robot.settings import SettingError, describe
from sim.encoders import Encoders
from sim.imperfections import LARGEST, Imperfections, draw
from sim.world import KinematicWorld

SPEC = RobotSpec.load()


def test_the_same_seed_draws_the_same_robot() -> None:
    one, same, other = (
        draw(SPEC, Imperfections(), np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert one.joints == same.joints
    assert one.joints != other.joints


def test_without_imperfections_the_robot_is_as_described() -> None:
    true = draw(SPEC, Imperfections.none(), np.random.default_rng(1))
    assert true.joints == SPEC.joints


@pytest.mark.slow
def test_errors_have_the_spread_that_is_asked_for() -> None:
    rng = np.random.default_rng(1)
    drawn = [draw(SPEC, Imperfections(), rng) for _ in range(60)]
    radii = np.array([joint.radius for spec in drawn for joint in spec.joints]) / 0.028 - 1
    tracks = np.array([spec.track for spec in drawn]) / 0.112 - 1
    assert radii.std() == pytest.approx(0.01, rel=0.2) and abs(radii.mean()) < 0.003
    assert tracks.std() == pytest.approx(0.02, rel=0.3) and abs(tracks.mean()) < 0.008
    assert np.abs(radii).max() <= LARGEST * 0.01 and np.abs(tracks).max() <= LARGEST * 0.02


def test_what_is_switched_off_does_not_change_the_rest() -> None:
    whole = draw(SPEC, Imperfections(), np.random.default_rng(3))
    wheels_only = draw(SPEC, Imperfections(track_sd=0), np.random.default_rng(3))
    assert [j.radius for j in whole.joints] == [j.radius for j in wheels_only.joints]
    assert wheels_only.track == pytest.approx(SPEC.track)


def test_a_robot_of_its_own_seed_is_the_same_in_all_runs() -> None:
    kept = Imperfections(robot=5, camera_angle_sd=0.3)
    one, same = (draw(SPEC, kept, np.random.default_rng(seed)) for seed in (1, 2))
    assert one.joints == same.joints
    np.testing.assert_array_equal(one.robot_from_camera, same.robot_from_camera)
    assert one.joints == draw(SPEC, Imperfections(), np.random.default_rng(5)).joints


@pytest.mark.slow
def test_a_camera_is_askew_by_as_much_as_is_asked_for_and_nothing_else_changes() -> None:
    askew = Imperfections(camera_angle_sd=0.3, camera_position_sd=0.001)
    drawn = [draw(SPEC, askew, np.random.default_rng(seed)) for seed in range(100)]
    mounts = np.array([spec.robot_from_camera for spec in drawn])
    turns = Rotation.from_matrix(SPEC.robot_from_camera[:3, :3].T @ mounts[:, :3, :3]).as_rotvec()
    moves = mounts[:, :3, 3] - SPEC.robot_from_camera[:3, 3]
    assert np.degrees(turns).std(axis=0) == pytest.approx(0.3, rel=0.2)
    assert moves.std(axis=0) == pytest.approx(0.001, rel=0.2)
    straight = draw(SPEC, Imperfections(), np.random.default_rng(7))
    assert drawn[7].joints == straight.joints
    np.testing.assert_array_equal(straight.robot_from_camera, SPEC.robot_from_camera)


def test_every_imperfection_is_documented_and_checked() -> None:
    known = describe(Imperfections)
    assert set(known) == set(vars(Imperfections()))
    assert all(entry.meaning for entry in known.values())
    for name, usual in vars(Imperfections()).items():
        with pytest.raises(SettingError, match=name):
            Imperfections(**{name: "often" if isinstance(usual, str) else -100})


def odometry_error(seed: int) -> float:
    """RMSE [m] of odometry over two laps of the figure-eight, unaligned."""
    rng = np.random.default_rng(seed)
    imperfections, drive = Imperfections(), DifferentialDrive(SPEC)
    world = KinematicWorld(draw(SPEC, imperfections, rng), step_time=0.02)
    encoders = Encoders(SPEC, imperfections, rng)
    by_odometry, (last, _) = Pose2(), encoders.read(world.positions, 0.0)
    errors = []
    for tick in range(1590):
        turning = 0.79 if tick * 0.02 % 15.9 < 7.95 else -0.79
        world.step(drive.wheels(Twist2(0.15, turning)))
        now, _ = encoders.read(world.positions, (tick + 1) * 0.02)
        by_odometry, last = by_odometry @ drive.moved(now - last), now
        errors.append(by_odometry.distance_to(world.pose))
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.slow
def test_odometry_alone_loses_its_way_as_it_does_in_reality() -> None:
    assert np.mean([odometry_error(seed) for seed in range(12)]) > 0.050
