"""Displacement: whether a place that was lost is found again where wheels led meanwhile."""

from __future__ import annotations

from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, State

FAR, FAR_SHARE = 0.05, 0.2
"""Wheels err by less than this [m] and this share of the way, if nobody pushes the robot."""
TURNED, TURNED_SHARE = 0.2, 0.3
"""The same of turns [rad]."""


class Displacement:
    """Remembers the last known place, and how the robot has driven since."""

    def __init__(self) -> None:
        """Begin with no known place."""
        self._state = State.SEARCHING
        self._forget()

    def _forget(self) -> None:
        self._known: Pose2 | None = None
        """The last known place, moved on by odometry; None before the first."""
        self._odometry = Pose2()
        self._way = self._turns = 0.0

    def was_displaced(self, state: State, pose: Pose2, odometry: Pose2) -> bool:
        """Return whether the place was found again, elsewhere than wheels led from the last one.

        Args:
            state: how far the pose can be relied on.
            pose: where the robot is held to be, in the map.
            odometry: the same moment's dead reckoning.
        """
        before, self._state = self._state, state
        if state is State.SEARCHING or (state is State.GIVEN and before is not State.GIVEN):
            self._forget()  # somebody has told the robot where it is, or that it may be anywhere
        elsewhere = False
        if self._known is not None:
            step = self._odometry.inverse() @ odometry
            self._known = self._known @ step
            self._way += abs(step.x) + abs(step.y)
            self._turns += abs(step.theta)
            if state is State.CERTAIN and before not in BOUNDED:
                elsewhere = (
                    self._known.distance_to(pose) > FAR + FAR_SHARE * self._way
                    or abs(self._known.turn_to(pose)) > TURNED + TURNED_SHARE * self._turns
                )
        if state in BOUNDED:
            self._known, self._way, self._turns = pose, 0.0, 0.0
        self._odometry = odometry
        return elsewhere
