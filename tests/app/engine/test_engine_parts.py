"""The same engine without a filter, with a laser instead of a camera, and with given odometry."""

from dataclasses import replace

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run

from app.engine.build import build_program, connect
from app.engine.follower import Follower
from app.features.lab.replay_robot import ReplayRobot
from app.settings.config import Config
from robot.geometry import Pose2
from robot.interface import Reading
from robot.localization.estimate import SEARCHING

pytestmark = pytest.mark.slow


def test_a_drive_without_a_filter_has_odometry_and_no_estimate():
    driven = run(kinematic(), 2.0, EIGHT)
    robot = ReplayRobot("A drive", (replace(each.reading, frame=None) for each in driven))
    engine = connect(Config(), robot, Follower(), driven[0].odometry)
    shown = [engine.step() for _ in driven]
    assert [each.odometry for each in shown] == [each.odometry for each in driven]
    last = shown[-1]
    assert (last.pose, last.estimate, last.integrity, last.filter.updates) == (
        None,
        None,
        SEARCHING,
        0,
    )
    # Nobody waits for pictures.
    assert last.problems.count == 0


def test_a_laser_s_scan_counts_as_the_picture_that_shows_the_same():
    driven = run(kinematic(), 2.0, EIGHT)
    scans = [
        replace(
            each.reading,
            frame=None,
            scan=each.filter.line_scan.scan if each.reading.frame else None,
        )
        for each in driven
    ]
    program = build_program(Config(robot="kinematic"), robot=ReplayRobot("A laser", scans))
    shown = [program.engine.step() for _ in scans]
    assert driven[-1].filter.updates > 10
    assert [each.pose for each in shown] == [each.pose for each in driven]
    assert shown[-1].filter.line_scan is None


def test_odometry_that_the_robot_computes_is_taken_as_it_is():
    poses = [Pose2(3.0, -2.0, 3.1), Pose2(3.2, -2.0, -3.1), Pose2(2.9, 1.0, 0.5)]
    still = np.zeros(2)
    robot = ReplayRobot(
        "A base", (Reading(0.1 * i, still, still, odom_from_robot=p) for i, p in enumerate(poses))
    )
    engine = connect(Config(), robot, Follower())
    assert [engine.step().odom_from_robot for _ in poses] == poses
    assert engine.controls.odometry.at(0.2).odom_from_robot == poses[-1]
