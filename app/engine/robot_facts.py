"""RobotFacts: what page, ROS and recordings need to know of a robot, wherever it is driven."""

from __future__ import annotations

from dataclasses import dataclass

from app.engine.problems import failing_alone
from robot.description.spec import RobotSpec
from robot.interface import PhysicalRobot, RepositionableRobot, Robot
from sim.simulated import SimulatedRobot


def close_robot(robot: Robot) -> None:
    """Close a robot; if it cannot be, that is logged: all else has to end, too."""
    with failing_alone(robot.name):
        robot.close()


@dataclass(frozen=True)
class RobotFacts:
    """What does not change while a robot drives."""

    name: str
    spec: RobotSpec
    """As it was described at the start."""
    engine: str | None
    """Name and version of the physics engine that moves it; None: none does."""
    can_be_placed: bool
    """Whether it can be put at any pose of the map."""
    has_faults: bool
    """Whether it is our simulation, whose faults can be set."""

    @classmethod
    def of(cls, robot: Robot) -> RobotFacts:
        """Return the facts of a robot in this process."""
        return cls(
            robot.name,
            robot.spec,
            robot.engine if isinstance(robot, PhysicalRobot) else None,
            isinstance(robot, RepositionableRobot),
            isinstance(robot, SimulatedRobot),
        )
