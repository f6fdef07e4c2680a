"""What tape looks like: how wide it is, whether it is lighter than its floor, and its dashes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tape:
    """One kind of tape on a floor."""

    width: float
    """[m]"""
    light: bool = False
    """Whether it is lighter than the floor around it."""
    dash: float = 0.0
    """Length of a dash [m]; 0 if the tape has no gaps."""


BLACK_TAPE = Tape(0.050)
"""The tape of a floor that is not described otherwise."""
