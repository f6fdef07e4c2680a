"""A route of straight legs, driven as odometry tells where the robot is."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.geometry import Pose2, Twist2, wrap_angle

SPEED, TURNING = 0.20, 1.2
"""Highest speed [m/s] and turning rate [rad/s]: tape in sight moves little between two pictures."""
SLOW_WITHIN = 0.08
"""The robot slows down this near to the end of a leg [m]."""
SLOWEST, SLOWEST_TURN = 0.03, 0.15
"""... but drives at least so fast [m/s, rad/s]."""
TURN_FIRST = 0.5
"""If the end of a leg is farther to the side than this, the robot turns on the spot [rad]."""
STEERING = 2.0
"""Turning rate by how far the end of a leg is to the side [1/s]."""
CLOSE, CLOSE_ANGLE = 0.02, 0.05
"""A place is reached within this distance [m], and a heading within this angle [rad]."""


@dataclass
class Route:
    """A way to a pose: straight there, then a turn; or a turn on the spot by an angle."""

    goal: Pose2
    """In the frame of odometry."""
    turn: float = 0.0
    """On the spot before all else, to the left [rad]; more than one turn is valid."""
    _heading: float | None = None
    _arrived: bool = False

    def twist(self, pose: Pose2) -> Twist2 | None:
        """Return the velocity at a pose of odometry; None at the end of the route."""
        if (remaining := self._remaining_turn(pose)) is not None:
            return Twist2(0.0, remaining)
        dx, dy = self.goal.x - pose.x, self.goal.y - pose.y
        distance = math.hypot(dx, dy)
        self._arrived |= distance < CLOSE
        if self._arrived:
            angle = wrap_angle(self.goal.theta - pose.theta)
            return None if abs(angle) < CLOSE_ANGLE else Twist2(0.0, _rate(angle))
        bearing = wrap_angle(math.atan2(dy, dx) - pose.theta)
        if abs(bearing) > TURN_FIRST:
            return Twist2(0.0, _rate(bearing))
        v = max(SLOWEST, SPEED * min(1.0, distance / SLOW_WITHIN)) * math.cos(bearing)
        # Near its end a leg is passed instead of circled around.
        self._arrived |= distance < 2 * CLOSE and abs(bearing) > TURN_FIRST / 2
        return Twist2(v, max(-TURNING, min(TURNING, STEERING * bearing)))

    def _remaining_turn(self, pose: Pose2) -> float | None:
        """Return the turning rate of the turn on the spot; None when it is done."""
        if self.turn == 0:
            return None
        if self._heading is not None:
            self.turn -= wrap_angle(pose.theta - self._heading)
        self._heading = pose.theta
        if abs(self.turn) >= CLOSE_ANGLE:
            return _rate(self.turn)
        self.turn = 0.0
        return None


def _rate(angle: float) -> float:
    """Return the turning rate for an angle that is left [rad/s]."""
    return math.copysign(max(SLOWEST_TURN, min(TURNING, STEERING * abs(angle))), angle)
