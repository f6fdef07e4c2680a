"""The robot of a replay: laser bags and recorded drives step the engine with its readings."""

from __future__ import annotations

from collections.abc import Iterable

from robot.description.spec import RobotSpec
from robot.geometry import Array
from robot.interface import Reading, RobotError


class ReplayRobot:
    """Satisfies ``Robot``; ignores wheel commands."""

    in_real_time = False

    def __init__(
        self, name: str, readings: Iterable[Reading], spec: RobotSpec | None = None
    ) -> None:
        """Replay readings of the described robot, or of one with another description."""
        self.name = name
        self.spec = spec or RobotSpec.load()
        self._readings = iter(readings)

    def read(self) -> Reading:
        """Return the next reading.

        Raises:
            RobotError: there are no more.
        """
        reading = next(self._readings, None)
        if reading is None:
            raise RobotError(f"{self.name} is over")
        return reading

    def write(self, velocities: Array) -> Array:
        """Return the velocities; they have no effect."""
        return velocities

    def close(self) -> None:
        """Do nothing: the robot holds no resources."""
