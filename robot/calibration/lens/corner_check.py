"""Which corners of a board were found in a wrong place."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

OFF_PX, OFF_SD = 1.5, 8.0
"""A corner is wrong that lies off its neighbours' places by both [px, standard deviations]."""
ROUNDS = 5
"""Most rounds; each one may leave out further corners."""


def in_place(flat: Array, pixels: Array) -> NDArray[np.bool_]:
    """Return which corners (n,) lie where their neighbours make them expected.

    A flat board is seen by a homography; what a lens does besides is a smooth polynomial, of the
    third degree.

    Args:
        flat: (n, 2) places on the board [m].
        pixels: (n, 2) places in the picture [px].
    """
    homography: Any = cv2.findHomography(flat, pixels, cv2.LMEDS)[0]
    if homography is None:  # the corners lie on one line
        return np.zeros(len(flat), np.bool_)
    straight = cv2.perspectiveTransform(flat.reshape(-1, 1, 2), homography).reshape(-1, 2)
    bent = pixels - straight
    x, y = ((flat - flat.mean(axis=0)) / np.ptp(flat, axis=0)).T
    powers = np.column_stack([x**i * y**k for i in range(4) for k in range(4 - i)])
    good = np.ones(len(flat), np.bool_)
    for _ in range(ROUNDS):
        if good.sum() < 2 * powers.shape[1]:
            # Too few for the polynomial: the homography alone has to do.
            powers = powers[:, :1]
        fitted = powers @ np.linalg.lstsq(powers[good], bent[good], rcond=None)[0]
        error = np.linalg.norm(bent - fitted, axis=1)
        limit = max(OFF_PX, OFF_SD * float(np.median(error[good])))
        worst = error[good].max()
        if worst <= limit:
            break
        # The worst pull the fit away from the good: they go first.
        good &= error < max(limit, 0.5 * float(worst))
    return good


def bend_px(flat: Array, pixels: Array) -> float:
    """Return how far corners (n, 2) lie off what a flat board shows without a lens [px], rms."""
    homography: Any = cv2.findHomography(flat, pixels)[0]
    if homography is None:
        return float("inf")
    straight = cv2.perspectiveTransform(flat.reshape(-1, 1, 2), homography).reshape(-1, 2)
    return float(np.sqrt(((pixels - straight) ** 2).sum(axis=1).mean()))
