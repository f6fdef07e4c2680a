"""Which routes a robot that explores is told, and in whose frame."""

import math
import pickle
from dataclasses import replace

import pytest
from engine_runs import kinematic, run
from serving import ask, serving, until

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
    # Where another process drives, a tick tells of a copy of the command.
    copy = pickle.loads(pickle.dumps(command))
    exploration.follow(replace(stands, commands=(copy,)), None, None, None)
    assert exploration.done, "no tape was seen, so that there is no next route"


@pytest.mark.slow
def test_a_robot_that_another_process_drives_goes_on_after_its_first_look_around() -> None:
    with serving("--map", "stub") as server, server.live() as live:
        ask(live, type="explore", start=True)

        def has_left(now: dict) -> bool:
            ask(live, type="explore")
            return math.hypot(now["truth"]["x"], now["truth"]["y"]) > 0.1

        until(live, has_left)
