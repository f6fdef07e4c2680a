"""Displacement: whether a place that was lost is found again where wheels led meanwhile."""

from __future__ import annotations

from collections.abc import Sequence

from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, State

FAR, FAR_SHARE = 0.05, 0.2
"""Wheels err by less than this [m] and this share of the way, if nobody pushes the robot."""
TURNED, TURNED_SHARE = 0.2, 0.3
"""The same of turns [rad]."""
LASTS = 10
"""A place that was lost is found if in so many pictures, one after the other, it is one of a few.
Which one need not be known: a robot that was lifted on a square is at none where wheels led."""


class Displacement:
    """Remembers the last known place, and how the robot has driven since."""

    def __init__(self) -> None:
        """Begin with no known place."""
        self._state = State.SEARCHING
        self._lost = False
        """Whether the place was lost since it was last known."""
        self._elsewhere = 0
        """In how many pictures, one after the other, all likely places were elsewhere."""
        self._forget()

    def _forget(self) -> None:
        self._known: Pose2 | None = None
        """The last known place, moved on by odometry; None before the first."""
        self._odometry = Pose2()
        self._way = self._turns = 0.0

    def was_displaced(self, state: State, places: Sequence[Pose2], odometry: Pose2) -> bool:
        """Return whether the place was found again, elsewhere than wheels led from the last one.

        Args:
            state: how far the pose can be relied on.
            places: where the robot may be, in the map, the likeliest first; none if it may be
                anywhere.
            odometry: the same moment's dead reckoning.
        """
        before, self._state = self._state, state
        if state is State.SEARCHING or (state is State.GIVEN and before is not State.GIVEN):
            self._forget()  # somebody has told the robot where it is, or that it may be anywhere
        self._lost |= state is State.LOST
        elsewhere = False
        if self._known is not None:
            step = self._odometry.inverse() @ odometry
            self._known = self._known @ step
            self._way += abs(step.x) + abs(step.y)
            self._turns += abs(step.theta)
            all_elsewhere = bool(places) and not any(map(self._is_where_wheels_led, places))
            if state is State.CERTAIN:
                elsewhere = before not in BOUNDED and all_elsewhere
            elif self._lost:
                one_of_few = state in (State.AMBIGUOUS, State.APPROXIMATE)
                self._elsewhere = self._elsewhere + 1 if one_of_few and all_elsewhere else 0
                elsewhere = self._elsewhere == LASTS
        if state in BOUNDED and places:
            self._known, self._way, self._turns = places[0], 0.0, 0.0
            self._lost, self._elsewhere = False, 0
        self._odometry = odometry
        return elsewhere

    def _is_where_wheels_led(self, place: Pose2) -> bool:
        assert self._known is not None
        near = self._known.distance_to(place) <= FAR + FAR_SHARE * self._way
        return near and abs(self._known.turn_to(place)) <= TURNED + TURNED_SHARE * self._turns
