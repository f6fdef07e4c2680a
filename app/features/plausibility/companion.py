"""Says that a motor counts anew: its plug was pulled and put back."""

from __future__ import annotations

import math
from collections.abc import Iterable

from app.engine.controls import Controls
from app.languages.marking import phrase
from app.messages.commands import Command
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, Robot

TOPIC = "motor_count"
SHOWN = 10.0
"""It is said for so long [s]."""
SAID = phrase(
    "A motor counts anew: was its plug pulled? Its way meanwhile is reckoned by its speed."
)


class PlausibilityCompanion:
    """Goes along with one engine, and looks at how its motors count."""

    needs_pictures = False
    shown = None

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Give no commands."""
        return ()

    def add(self, reading: Reading, controls: Controls) -> None:
        """Say so for a while after a motor began anew."""
        since = reading.stamp - controls.odometry.counted_anew
        if math.isfinite(since):
            controls.report(TOPIC, SAID if since < SHOWN else None)

    def close(self) -> None:
        """Do nothing: there is no thread."""


def plausibility_companion(
    config: Config, robot: Robot, field: Field
) -> Iterable[PlausibilityCompanion]:
    """Return what goes along with an engine."""
    return (PlausibilityCompanion(),)
