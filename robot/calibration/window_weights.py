"""How much is believed in the adjustment of a drive's first window, and of the longer ones."""

from __future__ import annotations

import numpy as np

from robot.calibration.adjustment import Weights
from robot.calibration.camera_from_tape import Guess
from robot.description.unknowns import COUNT, DELAY, LEFT, PRIORS, RIGHT, SEPARATION, index_of
from robot.geometry import Array

ALL_FREE_S = 12.0
"""In windows longer than this, nothing is stiff [s]."""


def window_weights(window: float, guess: Guess) -> list[Weights]:
    """Return how much is believed in the adjustments of a window [s], one after the other.

    In short windows the wheels and the place of the camera are stiff: with all free, a drive of two
    seconds is explained best by a robot of twice the size, or by one that looks aside.
    """
    free = np.ones(COUNT)
    if window < 3:
        turned = 0.1 * free
        turned[index_of(["camera_roll", "camera_pitch"])] = 1.0
        return [
            _guessed(guess, 0.01 * free, gate=0.25, doubt=100.0),
            _guessed(guess, turned, gate=0.15, doubt=30.0),
            _guessed(guess, turned, gate=0.08, doubt=8.0),
        ]
    if window < 6:
        free[[LEFT, RIGHT, SEPARATION, DELAY, *index_of(["camera_x", "camera_y"])]] = 0.1
        return [
            _guessed(guess, free, gate=0.06, doubt=8.0),
            _guessed(guess, free, gate=0.03, doubt=2.0),
        ]
    if window < ALL_FREE_S:
        return [_guessed(guess, free, gate=0.06, doubt=4.0), Weights(gate=0.03)]
    return [Weights()]


def _guessed(guess: Guess, stiffness: Array, gate: float, doubt: float) -> Weights:
    return Weights(guess.values, np.minimum(guess.sd, stiffness * PRIORS), gate, doubt)
