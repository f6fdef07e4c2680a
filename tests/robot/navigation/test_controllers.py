"""Controllers by name: an ideal robot with each of them arrives, and stays on its path."""

import math

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity, State
from robot.navigation.controllers import CONTROLLERS, RegulatedPurePursuit, Tracking
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.legs import curve, straight
from robot.navigation.navigator import Navigator
from robot.navigation.planning import NoWayError
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits, Wanted

TICK = 0.02
SURE = Integrity(State.CERTAIN, 0.01, 0.02)
LIMITS = Limits(0.2, 0.48, 0.5, 1.8, 3.2, 0.33, 0.056)
SETTINGS = NavigationSettings(command_lag=0.02)
FREE = FreeSpace.of(load_field("square", MAPS), RobotSpec.load().outline, SETTINGS)


class Fails:
    """Raises what an own controller raises."""

    by_time = True
    fault: str | None = "my.py line 3: no"

    def command(self, tracking: Tracking) -> Twist2:
        if self.fault:
            raise NoWayError(self.fault)
        return CONTROLLERS["tracker"].make().command(tracking)


def never(views, here, places, dares):
    raise AssertionError("it knows where it is")


def journey(controller, goal=(0.3, 0.2, 2.0), seconds=60.0):
    """Drive an ideal robot; returns the navigator and the poses."""
    navigator = Navigator((Goal(*goal),), SETTINGS, LIMITS, look=never, controller=controller)
    pose, twist, poses = Pose2(), Twist2(), []
    for count in range(round(seconds / TICK)):
        now = Sensed((count + 1) * TICK, pose, twist, SURE)
        if job := navigator.job(lambda: FREE, now):
            navigator.take(job())
        twist = navigator.step(now)
        pose = pose @ twist.integrate(TICK)
        poses.append(pose)
        if not navigator.status.active:
            break
    return navigator, poses


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize("goal", [(0.3, 0.2, 2.0), (-0.2, 0.1, 0.0), (0.01, 0.0, 0.0)])
def test_each_arrives_and_stays_on_the_path(name, goal):
    navigator, poses = journey(CONTROLLERS[name].make(), goal)
    assert navigator.status.state == "arrived"
    assert poses[-1].distance_to(Pose2(*goal)) < SETTINGS.xy_goal_tolerance
    path = navigator.status.path
    off = [np.hypot(*(path - (pose.x, pose.y)).T).min() for pose in poses]
    assert max(off) < 0.01


def test_one_that_fails_stands_says_why_and_drives_on_when_it_is_mended():
    controller = Fails()
    navigator, poses = journey(controller, seconds=4.0)
    assert (navigator.status.state, navigator.status.reason) == ("waiting", "my.py line 3: no")
    assert max(abs(pose.x) for pose in poses) < 0.02


def tracked(path, pose, twist=Twist2(0.2, 0.0), **more):
    wanted = Wanted(Pose2.from_array(path[0]), twist)
    return Tracking(pose, wanted, twist, path, more.pop("backwards", False), twist, 1.0, SETTINGS)


def test_pursuit_turns_towards_its_path_and_goes_straight_on_it():
    path = straight(Pose2(), 0.5).poses
    pursuit = RegulatedPurePursuit()
    assert pursuit.command(tracked(path, Pose2())).omega == pytest.approx(0, abs=1e-9)
    assert pursuit.command(tracked(path, Pose2(0, 0.02, 0))).omega < 0
    assert pursuit.command(tracked(path, Pose2(0, -0.02, 0))).omega > 0


def test_pursuit_drives_backwards_and_still_turns_towards_its_path():
    path = straight(Pose2(), -0.5).poses
    for beside in (0.02, -0.02):
        twist = RegulatedPurePursuit().command(
            tracked(path, Pose2(0, beside, 0), Twist2(-0.2, 0.0), backwards=True)
        )
        assert twist.v < 0
        after = Pose2(0, beside, 0) @ twist.integrate(0.3)
        assert abs(after.y) < abs(beside)


def test_pursuit_is_slower_in_narrow_bends_and_at_the_end():
    angles = np.linspace(0, 2, 100)
    bend = curve(0.1 * np.column_stack([np.sin(angles), 1 - np.cos(angles)])).poses
    pursuit = RegulatedPurePursuit()
    slow = pursuit.command(tracked(bend, Pose2())).v
    assert slow < 0.7 * SETTINGS.desired_linear_vel
    short = straight(Pose2(), 0.03).poses
    assert pursuit.command(tracked(short, Pose2())).v <= 0.3 * SETTINGS.desired_linear_vel


@pytest.mark.parametrize("reach", [0.1, 0.4])
def test_a_long_look_ahead_does_not_cut_corners(reach):
    settings = NavigationSettings(min_lookahead_dist=reach, max_lookahead_dist=reach)
    path = np.array([[0.005 * i, 0, 0] for i in range(21)] + [[0.1, 0.005 * i, math.pi / 2]
                    for i in range(1, 41)])  # fmt: skip
    wanted = Wanted(Pose2(), Twist2(0.2, 0))
    now = Tracking(Pose2(), wanted, Twist2(0.2, 0), path, False, Twist2(0.2, 0), 1.0, settings)
    assert abs(RegulatedPurePursuit().command(now).omega) < 0.3
