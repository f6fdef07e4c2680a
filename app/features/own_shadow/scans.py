"""Clears scans of what travels with the robot, and says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from app.engine.added_models import AddedModels
from app.features.own_shadow.still_returns import FEWEST, SAME, StillReturns
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.scan import Scan

SAID = phrase(
    "Something travels with the robot in its camera's view, as a cable or its own shadow does. "
    "It is not taken for tape; but it hides what is behind it."
)
EDGE = 0.01
"""So far before its return a thing may begin to hide the floor [m]."""
SHOWN = 3.0
"""It is said for so long after it was last seen [s]."""


class ClearedScans(AddedModels):
    """Offers no model: the program's own ones get scans without what travels with the robot."""

    def __init__(self) -> None:
        super().__init__()
        self._still = StillReturns()
        self._seen = -np.inf
        self._stamp = 0.0

    @property
    def problems(self) -> Mapping[str, str | None]:
        """Whether something travels with the robot."""
        since = self._stamp - self._seen  # a replay may be at an earlier time again
        return {"own_shadow": SAID if 0 <= since < SHOWN else None}

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan with such returns hidden, and all behind them."""
        still = self._still.find(scan, odometry)
        self._stamp = scan.stamp
        if not still.any():
            return scan
        if np.count_nonzero(still) >= FEWEST:
            self._seen = scan.stamp
        hidden = np.tile([np.inf, -np.inf], (len(still), 1))
        if scan.hidden is not None:
            hidden = scan.hidden.copy()
        hidden[still, 0] = np.minimum(hidden[still, 0], scan.ranges[still] - SAME - EDGE)
        hidden[still, 1] = np.inf
        return replace(scan, ranges=np.where(still, np.inf, scan.ranges), hidden=hidden)


def cleared_scans(config: Config, field: Field) -> list[ClearedScans]:
    """Return what clears an engine's scans."""
    return [ClearedScans()]
