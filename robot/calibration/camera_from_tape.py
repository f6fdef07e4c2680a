"""Estimates how the camera is mounted from tape alone, before anything else is known.

The two edges of straight tape are parallel, and their distance is the tape's width. They appear so
only if the camera's roll, pitch, height and focal length are right. The robot's pose and the shape
of the field do not matter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.calibration.sightings import FLOOR_SD, PIXEL_SD, FloorPoints, Sightings
from robot.description.unknowns import COUNT, PRIORS, index_of
from robot.geometry import Array

TOLD = index_of(["camera_roll", "camera_pitch", "camera_z", "focal_length"])
EXACT = np.array([math.radians(0.1), math.radians(0.2), 0.0003, 0.005])
"""Smallest standard deviations of ``TOLD`` [rad, rad, m, relative], because lenses, corners and
curves are not known exactly. The errors of simulated robots are half as large."""
MOST_PICTURES = 60
"""Number of pictures used, spread over the drive."""
RAYS = 5
"""Number of neighbouring rays that see one piece of tape."""
BENT, PARALLEL = 0.1, 0.97
"""How bent the sides of a piece of tape may be, and the least cosine between them."""
AGREEING = 1.0
"""If most errors of the width are larger than this, in standard deviations, there is no result."""
ENOUGH = 1e-4
"""Share by which the last step may still change the errors, or the unknowns."""
LEAST_PIECES = 100
"""With fewer pieces of tape there is no result."""
FAR_OFF, USUAL = 30.0, 3.0
"""Errors count less from this distance on, in standard deviations: at first and at last."""


@dataclass(frozen=True, eq=False)
class Guess:
    """The estimated unknowns, with their uncertainty."""

    values: Array = field(default_factory=lambda: np.zeros(COUNT))
    """(15,) differences from the description."""
    sd: Array = field(default_factory=PRIORS.copy)
    """(15,) their standard deviations."""


def camera_from_tape(seen: Sightings, twists: Array, width: float) -> Guess:
    """Estimate the camera from tape; the other unknowns keep their priors.

    Args:
        seen: the edges that were seen.
        twists: (k, 2) the robot's velocity at each picture [m/s, rad/s].
        width: width of the tape [m].
    """
    # Only the process that calibrates comes here; the page's own has no use for 10 MB of scipy.
    from scipy.optimize import least_squares  # noqa: PLC0415

    every = max(1, len(twists) // MOST_PICTURES)
    seen, twists = seen.every(every), twists[::every]
    pieces = _Pieces(seen, twists, width)
    if len(pieces.picture) < LEAST_PIECES:
        return Guess()
    # Where strokes overlap, tape is wider than drawn. Where they often do, errors that are far off
    # must not count from the beginning; elsewhere they have to, as all of them are far off.
    for scales in ((FAR_OFF, USUAL), (USUAL,)):
        shares = np.zeros(len(TOLD))
        for scale in scales:
            solution = least_squares(
                pieces.errors, shares, loss="cauchy", f_scale=scale, ftol=ENOUGH, xtol=ENOUGH
            )
            shares = solution.x
        if pieces.agree(shares):
            break
    else:
        return Guess()
    jacobian = np.asarray(solution.jac, np.float64)
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    values, sd = np.zeros(COUNT), PRIORS.copy()
    values[TOLD] = shares * PRIORS[TOLD]
    sd[TOLD] = np.maximum(EXACT, np.sqrt(np.diag(covariance)) * PRIORS[TOLD])
    return Guess(values, sd)


class _Pieces:
    """Pieces of tape, each seen by neighbouring rays of one picture."""

    def __init__(self, seen: Sightings, twists: Array, width: float) -> None:
        self._seen, self._twists, self._width = seen, twists, width
        rays = seen.pixels.shape[1] // 2
        whole = np.isfinite(seen.pixels[:, :rays, 0]) & np.isfinite(seen.pixels[:, rays:, 0])
        runs = np.lib.stride_tricks.sliding_window_view(whole, RAYS, axis=1).all(axis=2)
        picture, first = np.nonzero(runs)
        self.picture = picture[:, None]
        """(n, 1) index of the picture."""
        self._near = first[:, None] + np.arange(RAYS)
        self._far = self._near + rays
        straight = self._straight()
        self.picture = self.picture[straight]
        self._near, self._far = self._near[straight], self._far[straight]

    def _straight(self) -> NDArray[np.bool_]:
        """Return which pieces (n,) have straight sides that are about parallel.

        Pieces at corners do not. Straight lines look straight from any direction.
        """
        floor = self._seen.floor_points(np.zeros(COUNT), self._twists)
        directions, good = [], np.ones(len(self.picture), bool)
        for side in (self._near, self._far):
            points = floor.points[self.picture, side]
            around = np.nan_to_num(points - points.mean(axis=1, keepdims=True))
            spread, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
            good &= spread[:, 0] < (BENT * RAYS * np.sqrt(spread[:, 1]) / 10) ** 2
            directions.append(axes[:, :, 1])
        parallel = np.abs((directions[0] * directions[1]).sum(axis=1))
        result: NDArray[np.bool_] = good & (parallel > PARALLEL)
        return result

    def agree(self, shares: Array) -> bool:
        """Whether most pieces are as wide as the tape, with these unknowns (4,)."""
        gaps = self.errors(shares)[2 * RAYS * len(self.picture) : -len(TOLD)]
        return bool(np.median(np.abs(gaps)) < AGREEING)

    def errors(self, shares: Array) -> Array:
        """Return errors in standard deviations, and the priors' own.

        They are of straightness (n, 10), of the widths (n,) and of the unknowns (4,).

        Args:
            shares: (4,) the unknowns, in standard deviations of a robot that was built by hand.
        """
        values = np.zeros(COUNT)
        values[TOLD] = shares * PRIORS[TOLD]
        floor = self._seen.floor_points(values, self._twists)
        near, far = (floor.points[self.picture, side] for side in (self._near, self._far))
        middles = [side.mean(axis=1) for side in (near, far)]
        apart = middles[1] - middles[0]
        around = np.concatenate([near - middles[0][:, None], far - middles[1][:, None]], axis=1)
        _, axes = np.linalg.eigh(np.nan_to_num(np.einsum("nki,nkj->nij", around, around)))
        across = axes[:, :, 0]
        sd = self._sd(floor, across)
        straight = np.einsum("nki,ni->nk", around, across) / sd
        gap = np.abs((apart * across).sum(axis=1)) - self._width
        gap_sd = np.sqrt(2 * (sd**2).mean(axis=1) / RAYS)
        # Each ray is in as many pieces.
        errors = np.concatenate([straight.ravel(), gap / gap_sd]) / math.sqrt(RAYS)
        return np.concatenate([np.nan_to_num(errors, posinf=0.0, neginf=0.0), shares])

    def _sd(self, floor: FloorPoints, across: Array) -> Array:
        """Return the standard deviations (n, 10) of the distances across the tape [m]."""
        rays = np.concatenate([self._near, self._far], axis=1)
        by_pixel = np.einsum("ni,nkip->nkp", across, floor.by_pixel[self.picture, rays])
        sd: Array = np.hypot(PIXEL_SD * np.linalg.norm(by_pixel, axis=2), FLOOR_SD)
        return sd
