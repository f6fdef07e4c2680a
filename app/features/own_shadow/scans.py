"""Clears scans of what travels with the robot, and says so."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from app.engine.added_models import AddedModels
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.scan import Scan
from robot.scan_checks.still_returns import FEWEST, SAME, StillReturns

SAID = phrase(
    "Something travels with the robot in its camera's view, as a cable or its own shadow does. "
    "It is not taken for tape; but it hides what is behind it."
)
EDGE = 0.01
"""So far before its return a thing may begin to hide the floor [m]."""
SHOWN = 3.0
"""It is said for so long after it was last seen [s]."""


@dataclass(slots=True)
class _Memory:
    still: StillReturns = field(default_factory=StillReturns)
    seen: float = -math.inf
    """Stamp at which something travelled with the robot [s]."""
    stamp: float = 0.0


class ClearedScans(AddedModels):
    """Offers no model: the program's own ones get scans without what travels with the robot."""

    memory: _Memory

    def __init__(self) -> None:
        super().__init__()
        self.memory = _Memory()

    @property
    def problems(self) -> Mapping[str, str | None]:
        """Whether something travels with the robot."""
        shown = self.memory.stamp < self.memory.seen + SHOWN
        return {"own_shadow": SAID if shown else None}

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan with such returns hidden, and all behind them."""
        still = self.memory.still.find(scan, odometry)
        self.memory.stamp = scan.stamp
        if not still.any():
            return scan
        if np.count_nonzero(still) >= FEWEST:
            self.memory.seen = scan.stamp
        hidden = np.tile([np.inf, -np.inf], (len(still), 1))
        if scan.hidden is not None:
            hidden = scan.hidden.copy()
        hidden[still, 0] = np.minimum(hidden[still, 0], scan.ranges[still] - SAME - EDGE)
        hidden[still, 1] = np.inf
        return replace(scan, ranges=np.where(still, np.inf, scan.ranges), hidden=hidden)


def cleared_scans(config: Config, floor: Field) -> list[ClearedScans]:
    """Return what clears an engine's scans."""
    return [ClearedScans()]
