"""Lets a robot explore: commands the next route whenever it stands."""

from __future__ import annotations

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.mapping.messages import RouteCommand
from app.messages.driving_commands import StopCommand
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2
from robot.mapping.exploring import Explorer
from robot.mapping.sketch import Sketch

LATEST_S = 2.0
"""A route is planned when the map has all that the robot saw so far, or after this time [s]."""


class Exploration:
    """One exploring drive; for the thread that draws its map."""

    def __init__(self, program: Program) -> None:
        """Prepare for a program."""
        self._commands = program.engine.commands
        self._explorer = Explorer()
        self._stands_since: float | None = None
        self._sent: RouteCommand | None = None
        """A route that no tick has taken yet."""
        self.done = False
        """Whether there is nothing left to see."""

    @property
    def unseen(self) -> Array:
        """(n, 2) places in the map that were not seen, when it is done [m]."""
        return self._explorer.unseen

    def follow(
        self,
        snapshot: Snapshot,
        sketch: Sketch | None,
        map_from_odom: Pose2 | None,
        cells: OccupancyGrid | None,
    ) -> None:
        """Give the next route, if the robot explores and has come to the end of the last one.

        Args:
            snapshot: of a tick.
            sketch: the map so far; None if nothing was seen.
            map_from_odom: where odometry began in it.
            cells: the same map, with the floor that was seen.
        """
        if self._sent is not None and not any(item == self._sent for item in snapshot.commands):
            return
        self._sent = None
        if snapshot.mode != "explore" or self.done or snapshot.route is not None:
            self._stands_since = None
            return
        if self._stands_since is None:
            self._stands_since = snapshot.stamp
        drawn = sketch is not None and sketch.stamp >= self._stands_since
        waited = snapshot.stamp >= self._stands_since + LATEST_S
        if self._explorer.waits and not drawn and not waited:
            return
        known = map_from_odom or Pose2()
        route = self._explorer.next(sketch, known @ snapshot.odom_from_robot, cells)
        if route is None:
            self.done = True
            self._commands.put(StopCommand(type="stop"))
            return
        goal = known.inverse() @ route.goal
        self._sent = RouteCommand(
            type="route", x=goal.x, y=goal.y, theta=goal.theta, turn=route.turn
        )
        self._commands.put(self._sent)
