"""Integrity of an estimate: its state, its bounds, and reasons for doubt.

*Integrity* is a term of aviation. Information is misleading if it is claimed to be certain and the
truth lies outside the claimed bound. No information is better than misleading information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum


class State(StrEnum):
    """How far the estimate can be relied on."""

    CERTAIN = "certain"
    """One place, and the bound is narrow."""
    APPROXIMATE = "approximate"
    """One place with a wide bound, or without one while the place is in doubt."""
    AMBIGUOUS = "ambiguous"
    """Several places look alike."""
    SEARCHING = "searching"
    """No place stands out, or its bound is wider than a metre."""
    LOST = "lost"
    """The known place does not fit any more."""


class Cause(StrEnum):
    """What may be wrong when scans and odometry disagree with the models."""

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
    """The cause in plain words, with its size if that is known."""


@dataclass(frozen=True, slots=True)
class Integrity:
    """What the filter claims about an estimate."""

    state: State
    radius: float = math.inf
    """The true position lies within this distance of the estimate [m], in 99.9 % of pictures."""
    heading_bound: float = math.pi
    """The true heading lies within this angle of the estimate's [rad], in 99.9 % of pictures."""
    alerts: tuple[Alert, ...] = ()
    """The most recent reason for doubt first."""


SEARCHING = Integrity(State.SEARCHING)
"""The claim while nothing is known."""
