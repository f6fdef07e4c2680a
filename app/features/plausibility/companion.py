"""The companion looks, in each tick, at how motors count and where the robot is found again."""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.engine.controls import Controls
from app.features.plausibility.checks import PlausibilityChecks
from app.languages.marking import phrase
from app.messages.commands import Command
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, Robot
from robot.localization.estimate import ONLY_PLACE, Belief
from robot.scan import Scan

TOPIC = "motor_count"
LIKELY = 0.01
"""A place that is less likely than this share of the likeliest is not the robot's."""
SHOWN = 10.0
"""It is said for so long [s]."""
SAID = phrase(
    "A motor counts anew: was its plug pulled? Its way meanwhile is reckoned by its speed."
)


class PlausibilityCompanion:
    """Goes along with one engine."""

    needs_pictures = False
    shown = None

    def __init__(self) -> None:
        self._map_from_odom = Pose2()
        """Where somebody has put the robot, and that was told."""
        self._newest: tuple[Scan, Pose2] | None = None

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Give no commands."""
        return ()

    def add(self, reading: Reading, controls: Controls) -> None:
        """Say what was found, for a while."""
        self._look_at_place(controls)
        since = reading.stamp - controls.odometry.counted_anew
        if math.isfinite(since):
            controls.report(TOPIC, SAID if since < SHOWN else None)

    def _look_at_place(self, controls: Controls) -> None:
        localization = controls.localization
        newest, belief = localization.newest, localization.belief
        if newest is self._newest or newest is None or belief is None:
            return
        self._newest, odometry = newest, newest[1]
        for models in localization.added:
            if isinstance(models, PlausibilityChecks):
                if controls.map_from_odom != self._map_from_odom:
                    models.forget_place()
                state = localization.integrity.state
                models.look_at_place(state, likely_places(belief, odometry), odometry)
        self._map_from_odom = controls.map_from_odom

    def close(self) -> None:
        """Do nothing: there is no thread."""


def likely_places(belief: Belief, odometry: Pose2) -> tuple[Pose2, ...]:
    """Return where the robot may be, the likeliest first; nothing if it may be anywhere."""
    places, moved = belief.estimate.hypotheses, belief.moved(odometry)
    if sum(place.weight for place in places) < ONLY_PLACE:
        return ()
    return tuple(place.pose @ moved for place in places if place.weight > LIKELY * places[0].weight)


def plausibility_companion(
    config: Config, robot: Robot, field: Field
) -> Iterable[PlausibilityCompanion]:
    """Return what goes along with an engine."""
    return (PlausibilityCompanion(),)
