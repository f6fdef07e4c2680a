"""LookingAround: a robot that does not know its place moves, view by view, until it does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot.geometry import Pose2, Twist2
from robot.navigation.lookout import SEEN_MARGIN_M, Move
from robot.navigation.place_kernels import steps_clear
from robot.navigation.possible_places import Glimpse
from robot.navigation.seen_tape import tape_seen
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits, TimedWay, timed
from robot.navigation.tracker import follow

MOST_MOVES = 60
"""It makes so many moves to see more, and then waits."""
MOST_VIEWS = 24
"""It remembers so many views of them."""
LOOKS_S = 0.4
"""It stands so long for a view [s]."""
LOOKS_AGAIN_S = 3.0
"""It looks again so long after no move would have helped [s]."""
LOOKS_ENOUGH_S = 0.3
"""It has looked around when its place was known for so long [s]."""
GLANCE_ENDS_S = 0.3
"""A move to see more is over so long after its time [s]."""
WATCHED = 3
"""Of the moments of a move, each third one is compared with tape that comes into view: at 0.2 m/s
that is each 12 mm."""

Look = Callable[[tuple[Glimpse, ...], Pose2, tuple[Pose2, ...], int], Move]
"""Finds the move that tells most: from views, the odometry now, places that are believed in, and
how often there was none before."""


class LookingAround:
    """Moves of one journey by which the robot learns where it is."""

    def __init__(self, look: Look, limits: Limits, settings: NavigationSettings) -> None:
        """Prepare; ``look`` finds moves, in another thread."""
        self._look = look
        self._limits = limits
        self._settings = settings
        self.active = False
        """Whether it finds out where it is."""
        self._moves = 0
        """How often it has moved since it last knew its place."""
        self._views: list[Glimpse] = []
        """What it has seen since then."""
        self._in_vain = 0
        """How often it has looked and found no move, since the last move."""
        self._told = ""
        """Why it moves so, or not."""
        self._look_at = 0.0
        """When it looks [s]."""
        self._glance: TimedWay | None = None
        """The move to see more, in the odometry's frame."""
        self._clock = 0.0
        """How far that is driven [s]."""
        self._rim = np.zeros((0, 2))
        """The outline on that move, which shall not come to tape."""
        self._watched: Glimpse | None = None
        """The view in which tape was last looked for."""
        self._knows_since: float | None = None

    def job(self, tick: Sensed) -> Callable[[], Move] | None:
        """Return the work of finding a move, if the robot stands and has seen what it can."""
        if (
            self._glance is not None or tick.view is None or self._knows_since is not None
            or self._moves >= MOST_MOVES or tick.stamp < self._look_at or not tick.stands
        ):  # fmt: skip
            return None
        seen, views = tick.view, self._views
        if not views or views[-1].is_elsewhere(seen):
            self._views = views = [*views[1 - MOST_VIEWS :], seen]
        look, odom, places, dares = self._look, tick.odom, tick.places, self._in_vain
        return lambda: look(tuple(views), odom, places, dares)

    def take(self, move: Move, stamp: float) -> None:
        """Make a move that was found; one without legs is none."""
        self._told = move.reason
        self._in_vain = 0 if move.legs else self._in_vain + 1
        self._look_at = stamp + LOOKS_AGAIN_S
        if move.legs and self.active:
            self._moves += 1
            self._clock, self._glance = 0.0, timed(move.legs, self._limits)
            self._rim = move.rim

    def begin(self, stamp: float) -> None:
        """Look around from now on [s]."""
        self.active, self._moves, self._views, self._told = True, 0, [], ""
        self._in_vain = 0
        self._look_at = stamp + LOOKS_S
        self._glance = None

    def give_up_move(self) -> None:
        """Stand: what was a wall, or not, has changed."""
        self._glance = None

    def is_over(self, tick: Sensed, doubt: str) -> bool:
        """Whether the robot knows its place again, and stands; then it looks around no more."""
        if doubt:
            self._knows_since = None
            return False
        self._knows_since = tick.stamp if self._knows_since is None else self._knows_since
        if tick.stamp - self._knows_since < LOOKS_ENOUGH_S or not tick.stands:
            return False
        self.active, self._knows_since, self._glance = False, None, None
        return True

    def step(self, tick: Sensed, passed: float) -> Twist2:
        """Return the twist to command in this tick, so long [s] after the one before."""
        if self._glance is None or self._knows_since is not None:
            return Twist2()
        self._clock += passed
        over = self._clock >= self._glance.duration + GLANCE_ENDS_S
        if over or self._comes_to_tape(tick, self._glance):
            self._glance, self._look_at = None, tick.stamp + LOOKS_S
            return Twist2()
        wanted = self._glance.at(self._clock)
        ahead = self._glance.at(self._clock + self._settings.command_lag).twist
        return follow(tick.odom, wanted, ahead, self._settings)

    def _comes_to_tape(self, tick: Sensed, glance: TimedWay) -> bool:
        """Whether a new view shows tape in the way that is left of a move."""
        view, before = tick.view, self._watched
        if view is None or view is before or not len(self._rim):
            return False
        self._watched = view
        tape = tape_seen([view], Pose2())
        left = glance.ahead_of(self._clock, len(glance.times) - 1)[::WATCHED]
        return (
            steps_clear(np.ascontiguousarray(left), self._rim, tape, SEEN_MARGIN_M) < len(left) - 1
        )

    def reason(self, doubt: str) -> str:
        """Return in words why the robot stands, or moves to see more."""
        if not doubt:
            return "it knows its place again"
        if self._glance is not None:
            return f"{doubt}: it looks around, {self._told}"
        if self._moves >= MOST_MOVES:
            return f"{doubt}: it waits until it knows better"
        return f"{doubt}: {self._told or 'it looks'}"
