"""When a filter is asked: no motion is lost, and a scan counts once the robot has moved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from particle_robot import Tracker, standing_tracker, still, tracker_of
from stub_drive import DEFAULTS, STUB, Drive
from told_filters import NARROW, Told

from robot.geometry import Pose2, Twist2
from robot.localization.estimate import State
from robot.localization.filter import Cloud, Setup
from robot.localization.kalman_filter import KalmanFilter
from robot.localization.localizer import Localizer
from robot.localization.models.motion_models import DifferentialMotion
from robot.localization.monitoring.monitor import Monitor
from robot.localization.parameters import FilterParameters
from robot.localization.ray_evidence import RayEvidence
from robot.localization.refinement import Refinement
from robot.localization.scan_matching import ScanMatcher

SCAN = Drive().scan()


def localizer(refinement: Refinement | None = None, **changes: float) -> tuple[Localizer, Told]:
    told = Told()
    return Localizer(told, FilterParameters(**changes), refinement), told  # type: ignore[arg-type]


# --- what starts it anew


def test_a_pose_without_a_covariance_has_the_one_that_is_set() -> None:
    one, told = localizer(initial_sd_xy=0.2, initial_sd_theta=0.5)
    one.set_pose(Pose2(1, 2, 3))
    one.set_pose(Pose2(1, 2, 3), NARROW)
    wide = np.diag([0.2**2, 0.2**2, 0.5**2]).tolist()
    assert told.told == [(Pose2(1, 2, 3), wide), (Pose2(1, 2, 3), NARROW.tolist())]


def test_a_cloud_and_the_wish_to_scatter_are_passed_on() -> None:
    one, told = localizer()
    cloud = Cloud.even(np.zeros((2, 3)))
    one.set_cloud(cloud)
    one.scatter()
    assert told.told == [cloud, "scatter"]


@pytest.mark.parametrize("how", ["pose", "cloud", "scatter"])
def test_what_was_driven_before_a_start_is_in_it_already(how: str) -> None:
    one, told = localizer()
    one.update(Pose2(), SCAN)
    one.update(Pose2(0.5), SCAN)
    assert one.updates == 2
    if how == "pose":
        one.set_pose(Pose2())
    elif how == "cloud":
        one.set_cloud(told.cloud)
    else:
        one.scatter()
    assert one.updates == 0
    told.told.clear()
    assert one.update(Pose2(0.9), SCAN) is not None, "the first scan counts"
    assert told.told == [Pose2(), SCAN]
    assert one.updates == 1


# --- when a scan counts


def test_the_first_scan_counts_and_then_none_while_it_stands() -> None:
    one, told = localizer()
    assert one.update(Pose2(3, 4), SCAN) is not None
    assert told.told == [Pose2(), SCAN]
    assert one.update(Pose2(3, 4), SCAN) is None
    assert told.told == [Pose2(), SCAN] and one.updates == 1


@pytest.mark.parametrize(
    ("moved", "counts"),
    [
        (Pose2(0.0099), False),
        (Pose2(0.0101), True),
        (Pose2(-0.0101), True),
        (Pose2(0.006, 0.006), False),
        (Pose2(0.0075, 0.0075), True),
        (Pose2(0, 0, 0.099), False),
        (Pose2(0, 0, 0.101), True),
        (Pose2(0, 0, -0.101), True),
    ],
    ids=str,
)
@pytest.mark.parametrize("start", [Pose2(), Pose2(2, 3, math.pi - 0.05)], ids=str)
def test_enough_way_or_turn_makes_a_scan_count(start: Pose2, moved: Pose2, counts: bool) -> None:
    one, _ = localizer(update_min_d=0.01, update_min_a=0.1)
    one.update(start, SCAN)
    assert (one.update(start @ moved, SCAN) is not None) == counts
    assert one.updates == 1 + counts


def test_small_steps_add_up_until_they_count() -> None:
    one, told = localizer(update_min_d=0.01)
    counted = [one.update(Pose2(0.003 * tick), SCAN) is not None for tick in range(9)]
    assert [tick for tick, c in enumerate(counted) if c] == [0, 4, 8]
    steps = [step.x for step in told.told if isinstance(step, Pose2)]
    assert steps == pytest.approx([0, 0.012, 0.012])


def test_steps_are_seen_from_where_they_start() -> None:
    one, told = localizer()
    one.update(Pose2(1, 1, math.pi / 2), SCAN)
    one.update(Pose2(1, 1.5, math.pi), SCAN)
    step = told.told[2]
    assert isinstance(step, Pose2)
    np.testing.assert_allclose(step.to_array(), [0.5, 0, math.pi / 2], atol=1e-12)


def test_a_forced_update_counts_once_though_it_stands() -> None:
    one, _ = localizer()
    one.update(Pose2(), SCAN)
    one.force_update()
    assert one.update(Pose2(), SCAN) is not None
    assert one.update(Pose2(), SCAN) is None


def test_odometry_alone_is_followed_by_the_same_rule_and_counts_no_scan() -> None:
    one, told = localizer(update_min_d=0.01)
    assert [one.predict(Pose2(0.003 * tick)) for tick in range(6)] == [*[False] * 4, True, False]
    assert len(told.told) == 1 and one.updates == 0
    one.update(Pose2(0.02), SCAN)
    steps = [step.x for step in told.told if isinstance(step, Pose2)]
    assert steps == pytest.approx([0.012, 0.008]), "what was not yet followed is not lost"


def test_new_parameters_count_at_once() -> None:
    one, _ = localizer(update_min_d=0.01)
    one.update(Pose2(), SCAN)
    one.parameters = replace(one.parameters, update_min_d=0.5)
    assert one.update(Pose2(0.4), SCAN) is None


# --- what it says


def test_an_estimate_is_the_filters_with_the_stamp_of_the_scan() -> None:
    one, told = localizer()
    found = one.update(Pose2(), SCAN)
    assert found is not None
    assert found.stamp == SCAN.stamp and found.effective == 33
    assert found.hypotheses == told.hypotheses
    later = one.estimate(9.0)
    assert later is not None and later.stamp == 9 and later.hypotheses == told.hypotheses


def test_while_nothing_is_known_nothing_is_said_but_scans_are_taken() -> None:
    one, told = localizer(refinement())
    told.hypotheses = ()
    assert one.update(Pose2(), SCAN) is None
    assert one.estimate(0.0) is None
    assert told.told == [Pose2(), SCAN] and one.updates == 1


def refinement() -> Refinement:
    return Refinement(ScanMatcher(STUB.edge_index, 1.0, 0.003, 0.03), 100)


def test_only_the_heaviest_is_made_finer_and_the_filter_does_not_learn_of_it() -> None:
    one, told = localizer(refinement())
    rough = told.hypotheses
    found = one.update(Pose2(), SCAN)
    assert found is not None
    assert found.pose == refinement().refine(rough[0], SCAN).pose != rough[0].pose
    assert abs(found.pose.x) < 0.0005
    assert found.hypotheses[0].weight == 0.6
    assert found.hypotheses[1:] == rough[1:]
    assert told.hypotheses == rough and told.told == [Pose2(), SCAN]


# --- with particles


@pytest.fixture
def standing() -> Tracker:
    return standing_tracker()


@pytest.mark.parametrize("way", [0.3, -0.02])
def test_what_is_driven_between_a_told_pose_and_the_next_picture_counts(way: float) -> None:
    """Also backwards: a picture that was exposed before the pose was told."""
    robot, told = localizer()
    robot.now = Pose2(1.0, 2.0, 0.5)
    robot.set_pose(Pose2(), NARROW)
    robot.update(robot.now @ Pose2(way), SCAN)
    moved = next(one for one in told.told if isinstance(one, Pose2))
    assert moved.distance_to(Pose2(way)) < 1e-12


def test_what_was_driven_before_a_pose_is_told_is_not_driven_again() -> None:
    f, drive = tracker_of(update_min_d=5.0, update_min_a=6.0), Drive()
    f.told(drive.true, 0.01, 0.01)
    f.update(drive.odometry, drive.step(Twist2())[1])
    for _ in drive.eight(3.0):
        pass
    f.update(drive.odometry, drive.step(Twist2())[1])
    f.told(drive.true, 0.01, 0.01)
    estimate = f.update(drive.odometry, drive.step(Twist2())[1])
    assert estimate is not None
    assert estimate.pose.distance_to(drive.true) < 0.01


def test_particles_stay_as_they_are_while_the_robot_stands(standing: Tracker) -> None:
    before = standing.cloud
    for _ in range(5):
        assert still(standing) is None
    assert standing.cloud is before
    assert standing.updates == 1


@pytest.mark.parametrize(
    ("moved", "counts"),
    [
        (Pose2(0.0019), False),
        (Pose2(0.0021), True),
        (Pose2(0, -0.0021), True),
        (Pose2(0, 0, 0.0049), False),
        (Pose2(0, 0, 0.0051), True),
        (Pose2(0, 0, -0.0051), True),
    ],
)
def test_by_default_two_millimetres_or_five_milliradians_make_a_scan_count(
    standing: Tracker, moved: Pose2, counts: bool
) -> None:
    assert (still(standing, moved) is not None) == counts


def test_small_steps_add_up_until_particles_move_and_none_is_lost() -> None:
    f = tracker_of(update_min_d=0.01)
    f.filter.motion = DifferentialMotion(0, 0, 0, 0)
    f.set_cloud(Cloud.even(np.zeros((50, 3))))
    f.predict(Pose2())
    counted = [f.predict(Pose2(0.003 * tick)) for tick in range(1, 12)]
    assert [tick for tick, c in enumerate(counted, start=1) if c] == [4, 8]
    np.testing.assert_allclose(f.cloud.poses[:, 0], 0.024)


def test_particles_take_a_forced_scan_once_though_the_robot_stands(standing: Tracker) -> None:
    standing.force_update()
    assert still(standing) is not None
    assert still(standing) is None


def test_a_told_pose_makes_the_next_scan_count(standing: Tracker) -> None:
    standing.told(Pose2(), 0.02, 0.05)
    assert still(standing) is not None


def test_paused_the_cloud_follows_odometry_and_spreads() -> None:
    f, drive = tracker_of(), Drive(Pose2(0.1, 0, 0.5))
    f.told(drive.true, 0.005, 0.01)
    f.predict(drive.odometry)
    narrow = f.estimate(0.0).covariance.trace()
    for _ in drive.eight(2.0):
        f.predict(drive.odometry)
    estimate = f.estimate(2.0)
    there = Pose2(0.1, 0, 0.5) @ drive.odometry
    assert estimate.pose.distance_to(there) < 0.01
    assert estimate.covariance.trace() > 2 * narrow
    assert f.updates == 0
    assert f.filter.cloud is f.cloud


def test_standing_at_another_place_than_it_says_it_is_certain_no_more() -> None:
    """No scan is due while odometry stands: somebody has carried the robot off."""
    drive = Drive(Pose2(0.1, 0.0, 0.5))
    belief = KalmanFilter.of(Setup.of_field(STUB, DEFAULTS), np.random.default_rng(0))
    monitor = Monitor(RayEvidence.of(STUB, range_max=1.0, sd=0.005))
    one = Localizer(belief, FilterParameters(), monitor=monitor)
    one.set_pose(drive.true, NARROW)
    for _, scan in drive.eight(1.0):
        one.update(drive.odometry, scan)
    for elsewhere in (False, True):
        drive.true = drive.true @ Pose2(theta=0.6 * elsewhere)
        updates = [one.update(drive.odometry, drive.scan()) for _ in range(10)]
        assert set(updates) == {None}
        assert (one.integrity.state is State.CERTAIN) == (not elsewhere)
