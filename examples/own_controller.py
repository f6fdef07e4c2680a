"""A planner and a controller of one's own: the way over one corner, and a controller for it."""

import math
from pathlib import Path

from app.features.navigation.messages import GoalMessage, NavigateCommand
from brickpose import Config, Pose2, build_program
from robot.navigation.controllers import Tracking
from robot.navigation.free_space import FreeSpace


def corners(space: FreeSpace, start: Pose2, goal: Pose2) -> list[tuple[float, float]]:
    """Return the corners [m] of a way from a pose to another one; None is none."""
    return [(start.x, start.y), (goal.x, start.y), (goal.x, goal.y)]


def command(tracking: Tracking) -> tuple[float, float]:
    """Return v [m/s] and omega [rad/s]: as wanted now, and back to the path."""
    error = tracking.pose.inverse() @ tracking.wanted.pose
    v = tracking.ahead.v * math.cos(error.theta) + 2.0 * error.x
    return v, tracking.ahead.omega + 4.0 * error.theta + 300.0 * abs(tracking.ahead.v) * error.y


if __name__ == "__main__":
    here = Path(__file__)
    chosen = {"planner": f"{here}:corners", "controller": f"{here}:command"}
    program = build_program(Config(map="square", seed=1, added={"navigation": chosen}))
    engine = program.engine
    goal = GoalMessage(x=0.25, y=0.2, theta=math.pi / 2)
    engine.commands.put(NavigateCommand(type="navigate", poses=[goal]))
    for _ in range(1500):
        snapshot = engine.step()
        engine.commands.put(NavigateCommand(type="navigate"))
    status = snapshot.added["navigation"]
    print(status.state, status.reason, snapshot.truth, sep="; ")
    program.robot.close()
