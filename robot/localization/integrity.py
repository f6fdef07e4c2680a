"""What the filter claims to know of its own answer: a state, bounds that hold, reasons for doubt.

*Integrity* as aviation has it: information is misleading when it is claimed to be certain and the
truth lies outside the claimed bound. No information is better than that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum


class State(StrEnum):
    """How far the answer may be relied on."""

    CERTAIN = "certain"
    """One place, and the bound is narrow."""
    APPROXIMATE = "approximate"
    """One place, and the bound is wide."""
    AMBIGUOUS = "ambiguous"
    """Several places look alike."""
    SEARCHING = "searching"
    """No place stands out: it looks around."""
    LOST = "lost"
    """The place that was known does not fit any more."""


class Cause(StrEnum):
    """What may be wrong when scans and odometry do not fit what the models claim."""

    CAMERA_ASKEW = "camera askew"
    PICTURES_LATE = "pictures late"
    WHEEL_SLIP = "wheel slip"
    WHEEL_SIZE = "wheel size"
    MAP = "map"
    MODEL = "model"


@dataclass(frozen=True, slots=True)
class Alert:
    """A reason for doubt."""

    cause: Cause
    text: str
    """In plain words, with its size."""


@dataclass(frozen=True, slots=True)
class Integrity:
    """What is claimed of an estimate."""

    state: State
    radius: float = math.inf
    """The true place lies within this distance of the estimate [m], in 99.9 % of pictures."""
    heading_bound: float = math.pi
    """The true heading lies within this angle of the estimate's [rad], in 99.9 % of pictures."""
    alerts: tuple[Alert, ...] = ()
    """The likeliest reason first."""


SEARCHING = Integrity(State.SEARCHING)
"""While nothing is known."""
