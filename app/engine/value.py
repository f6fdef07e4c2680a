"""A value that ticks show: one line puts it on the page, on ROS and into recordings."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.engine.snapshot import Snapshot
from app.feature_search import reason_of
from app.languages.marking import phrase

LOG = logging.getLogger("brickpose")

Shown = bool | float | int | str | None

UNREADABLE: dict[str, str] = {}
"""Why values cannot be read now, by their names."""


@dataclass(frozen=True)
class Value:
    """One value of a tick: a figure of the topic ``diagnostics``, which recordings have as well.

    The page lists it in its bar, from ``TelemetryMessage.values``.
    """

    name: str
    """As ``bare_pictures``; a unit is its last word, as in ``latency_ms``."""
    read: Callable[[Snapshot], Shown]
    """Reads it from a tick; None if it is not known. It is asked by several threads, and again for
    the same tick, so it only reads. If it raises, the value is unknown, and named as a problem."""
    form: str = ""
    """How its number is written, as ``.1f``."""
    listed: bool = True
    """Whether the page lists it; False if telemetry has it elsewhere."""

    def shown(self, snapshot: Snapshot) -> Shown:
        """Return it, a number rounded as it is written; None if it is unknown or no number."""
        try:
            value = _plain(self.read(snapshot))
            if isinstance(value, float) and self.form:
                value = float(format(value, self.form))
        except Exception as error:
            if self.name not in UNREADABLE:
                LOG.exception("the value %s cannot be read", self.name)
            why = reason_of(error)
            UNREADABLE[self.name] = phrase(f"The value {self.name} cannot be read: {why}.")
            return None
        UNREADABLE.pop(self.name, None)
        return value

    def text(self, snapshot: Snapshot) -> str:
        """Return it as ROS has it: a truth value is true or false, and what is unknown empty."""
        value = self.shown(snapshot)
        if value is None:
            return ""
        if isinstance(value, bool):
            return str(value).lower()
        return value if isinstance(value, str) else format(value, self.form)


def _plain(value: Any) -> Shown:
    """Return a value as messages have it; what is no finite number is unknown."""
    if isinstance(value, np.generic):
        value = value.item()
    if not isinstance(value, bool | float | int | str | None):
        raise TypeError(f"it is {type(value).__name__}; valid is a number, a truth value or a text")
    return None if isinstance(value, float) and not math.isfinite(value) else value
