"""Finds in a drive when the robot was pushed: it moved otherwise than its wheels tell."""

from __future__ import annotations

import numpy as np

from robot.calibration.drive_path import MOST_SLIP
from robot.geometry import Array

MOST_STEP = 6.0
"""A step is at most this far from what the wheels tell, in standard deviations."""


def moved_at(step_errors: Array, slip: Array, stamps: Array) -> float | None:
    """Return when the robot was first pushed or slipped [s since the first picture]; or None.

    Args:
        step_errors: (k - 1, 3) how far each step is from what the wheels tell, in deviations.
        slip: (k, 2) of the wheels.
        stamps: (k,) of the pictures [s]; later ones are ignored.
    """
    jumps = np.abs(step_errors).max(axis=1, initial=0.0) > MOST_STEP
    jumps |= np.abs(slip[1:]).max(axis=1, initial=0.0) > MOST_SLIP
    return float(stamps[1 + np.argmax(jumps)] - stamps[0]) if jumps.any() else None


def push_remark(seconds: float, *, is_noise: bool) -> str:
    """Return the remark on a push after a time [s]; of none, if what is left over is no noise."""
    if not is_noise:
        return (
            f"at {seconds:.0f} s pictures and wheels disagree on how the robot moved: it is not as "
            "described, or it was pushed; calibrate it, and draw the map anew: this may be bent"
        )
    return (
        f"at {seconds:.0f} s pictures and wheels disagree on how the robot moved: it was pushed, "
        "or a wheel slipped; look at the map, which may be bent there, and draw it anew if it is"
    )
