"""How far an estimate may be off, beyond its covariance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array
from robot.localization.estimate import Alert


@dataclass(frozen=True, slots=True, eq=False)
class Doubt:
    """How far an estimate may be off by errors that its covariance does not include."""

    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad] of the errors that were found; zero if none was."""
    unknown: Array = field(repr=False)
    """(3, 3) of the errors that were not found, but cannot be excluded yet."""
    alerts: tuple[Alert, ...]
    fits: bool
    """Whether the last scans fit at the estimate, and the steps of the pose agree with odometry."""


NO_DOUBT = Doubt(np.zeros((3, 3)), np.zeros((3, 3)), (), True)
