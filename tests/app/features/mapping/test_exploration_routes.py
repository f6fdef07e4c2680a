"""Which routes a robot that explores is told, and in whose frame."""

from dataclasses import replace

import pytest
from engine_runs import kinematic, run

from app.features.mapping.exploration import LATEST_S, Exploration
from app.features.mapping.messages import RouteCommand
from robot.geometry import Pose2


def test_a_route_is_told_in_the_frame_of_odometry_wherever_that_began_in_the_map() -> None:
    """The first route turns on the spot, so its goal is where the robot stands by odometry."""
    program = kinematic()
    driven = Pose2(0.4, -0.1, 0.7)
    tick = replace(run(program, 0.1)[-1], mode="explore", odom_from_robot=driven)
    exploration = Exploration(program)
    for elapsed in (0.0, 0.5 * LATEST_S, LATEST_S):
        assert program.engine.commands.take() == ()
        stands = replace(tick, stamp=tick.stamp + elapsed)
        exploration.follow(stands, None, Pose2(0.3, -0.2, 1.1), None)
    (command,) = program.engine.commands.take()
    assert isinstance(command, RouteCommand)
    goal = (command.x, command.y, command.theta)
    assert goal == pytest.approx((driven.x, driven.y, driven.theta))
