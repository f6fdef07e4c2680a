"""Adjusts a lens and the poses of a board to all pictures together (bundle adjustment).

Levenberg-Marquardt on the distances between seen and projected corners; OpenCV projects and
differentiates. Each picture's pose is tied to the lens only, so poses are eliminated first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from robot.calibration.lens.board import Board
from robot.calibration.lens.sighting import Sighting
from robot.camera import CameraError, Lens
from robot.distortion import COEFFICIENTS
from robot.geometry import Array

ROUNDS = 60
"""Most steps of an adjustment."""
SETTLED = 1e-9
"""A step that makes the squared errors smaller by less than this share is the last."""
COEFFICIENT_SD = 10.0
"""How large coefficients of distortion may be: those of the rational model cancel each other."""
FOCALS = (0.35, 0.6, 1.0, 1.7)
"""Focal lengths to begin with, by the picture's width."""


@dataclass(frozen=True, eq=False)
class LensFit:
    """A lens that was adjusted to pictures."""

    lens: Lens
    poses: Array = field(repr=False)
    """(k, 6) rotation vector and place [m] of the board in the camera's frame."""
    errors: tuple[Array, ...] = field(repr=False)
    """(n, 2) of each picture: how far the seen corners lie from the projected ones [px]."""
    covariance: Array = field(repr=False)
    """(p, p) of fx, fy, cx, cy and the coefficients, by the corners' scatter."""
    converged: bool = True
    """Whether a further step would change nothing."""

    @property
    def rms(self) -> float:
        """Root mean square distance between seen and projected corners [px]."""
        return rms_of(self.errors)

    @property
    def sd(self) -> Array:
        """(p,) standard deviations of fx, fy, cx, cy and the coefficients."""
        return np.sqrt(np.diag(self.covariance))


def rms_of(errors: Sequence[Array]) -> float:
    """Return the root mean square distance of errors (n, 2) of pictures [px]."""
    every = np.concatenate(list(errors))
    return float(np.sqrt((every**2).sum(axis=1).mean()))


def first_fit(model: str, seen: Sequence[Sighting], board: Board) -> LensFit:
    """Fit a lens of which nothing is known, from several focal lengths; the best fit counts.

    Raises:
        CameraError: no lens of this model fits at all.
    """
    width, height = seen[0].size
    fits = []
    for share in FOCALS:
        focal = share * width
        matrix = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
        start = Lens(width, height, matrix, np.zeros(len(COEFFICIENTS[model])), model=model)
        try:
            fits.append(fit_lens(start, seen, board))
        except (CameraError, np.linalg.LinAlgError, cv2.error):
            continue  # from this focal length it went astray
    if not fits:
        raise CameraError(f"no lens of the model {model} fits the pictures")
    return min(fits, key=lambda fit: fit.rms)


def fit_lens(start: Lens, seen: Sequence[Sighting], board: Board) -> LensFit:
    """Adjust a lens, from a first guess.

    Raises:
        CameraError: the adjustment ends in no lens.
    """
    poses = np.array([board_pose(start, sighting, board) for sighting in seen])
    focal, centre = start.matrix[[0, 1], [0, 1]], start.matrix[:2, 2]
    values = np.concatenate([focal, centre, start.distortion])
    prior = np.concatenate([np.zeros(4), np.full(len(start.distortion), COEFFICIENT_SD**-2.0)])
    damping, total, converged = 1e-3, np.inf, False
    parts = _linearized(start.model, values, poses, seen, board)
    for _ in range(ROUNDS):
        total = _cost(parts) + float(prior @ values**2)
        step, turns = _step(parts, values, prior, damping)
        trial = _linearized(start.model, values + step, poses + turns, seen, board)
        cost = _cost(trial) + float(prior @ (values + step) ** 2)
        if not cost < total:
            damping *= 10
            if damping > 1e8:
                # No step however small leads lower.
                converged = True
                break
            continue
        values, poses, parts = values + step, poses + turns, trial
        damping = max(damping / 10, 1e-12)
        if total - cost < SETTLED * total:
            converged = True
            break
    return replace(_result(start, values, poses, parts, prior), converged=converged)


def board_pose(lens: Lens, sighting: Sighting, board: Board) -> Array:
    """Return the pose (6,) of a board in the camera's frame: rotation vector and place [m].

    Raises:
        CameraError: the lens shows too few of the corners, so that there is no pose.
    """
    rays = lens.unproject(sighting.pixels)
    good = np.isfinite(rays[:, 0])
    if good.sum() < 4:
        raise CameraError("the lens bends no light to the corners of the board")
    _, turns, places, _ = cv2.solvePnPGeneric(
        board.corners[sighting.ids][good], rays[good, :2].copy(), np.eye(3), None,
        flags=cv2.SOLVEPNP_IPPE,
    )  # fmt: skip
    return np.concatenate([np.ravel(turns[0]), np.ravel(places[0])])


def held_out_errors(lens: Lens, sighting: Sighting, board: Board, pose: Array) -> Array:
    """Return the errors (n, 2) [px] of a picture that the lens was not adjusted to."""
    return fit_pose(lens, sighting, board, pose).errors


@dataclass(frozen=True, eq=False)
class PoseFit:
    """Where a board is, by one picture through a known lens."""

    pose: Array
    """(6,) rotation vector and place [m] of the board in the camera's frame."""
    errors: Array = field(repr=False)
    """(n, 2) how far the seen corners lie from the projected ones [px]."""
    information: Array = field(repr=False)
    """(6, 6) inverse covariance of the pose, for corners that scatter by a pixel."""


def fit_pose(lens: Lens, sighting: Sighting, board: Board, pose: Array) -> PoseFit:
    """Adjust the pose (6,) of a board to one picture, from a first guess."""
    values = np.concatenate([lens.matrix[[0, 1], [0, 1]], lens.matrix[:2, 2], lens.distortion])
    for _ in range(10):
        (part,) = _linearized(lens.model, values, pose[None], [sighting], board)
        information = part.by_pose.T @ part.by_pose
        pose = pose + np.linalg.solve(information, part.by_pose.T @ part.error)
    (part,) = _linearized(lens.model, values, pose[None], [sighting], board)
    return PoseFit(pose, part.error.reshape(-1, 2), part.by_pose.T @ part.by_pose)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One picture's errors, and how its projected corners move with the unknowns."""

    error: Array
    by_lens: Array
    by_pose: Array


def _linearized(
    model: str, values: Array, poses: Array, seen: Sequence[Sighting], board: Board
) -> list[_Part]:
    result = []
    matrix = np.array([[values[0], 0, values[2]], [0, values[1], values[3]], [0, 0, 1]])
    for pose, sighting in zip(poses, seen, strict=True):
        points, turn, place = board.corners[sighting.ids], pose[:3], pose[3:]
        if model == "equidistant":
            pixels, slopes = cv2.fisheye.projectPoints(
                points.reshape(-1, 1, 3), turn, place, matrix, values[4:]
            )
            by_lens, by_pose = slopes[:, :8], slopes[:, 8:14]
        else:
            pixels, slopes = cv2.projectPoints(points, turn, place, matrix, values[4:])
            by_pose, by_lens = slopes[:, :6], slopes[:, 6 : 6 + len(values)]
        error = (sighting.pixels - pixels.reshape(-1, 2)).ravel()
        result.append(_Part(error, np.asarray(by_lens, float), np.asarray(by_pose, float)))
    return result


def _cost(parts: Sequence[_Part]) -> float:
    total = float(sum(part.error @ part.error for part in parts))
    return total if np.isfinite(total) else np.inf


def _step(
    parts: Sequence[_Part], values: Array, prior: Array, damping: float
) -> tuple[Array, Array]:
    """Return the step of the lens (p,) and of the poses (k, 6)."""
    reduced, right, rest = _reduced(parts, prior, damping)
    step: Array = np.linalg.solve(reduced, right - prior * values).astype(np.float64)
    turns = [inverse @ (pull - shared.T @ step) for inverse, shared, pull in rest]
    return step, np.array(turns)


def _reduced(
    parts: Sequence[_Part], prior: Array, damping: float
) -> tuple[Array, Array, list[tuple[Array, Array, Array]]]:
    """Return the normal equations of the lens without the poses, and what poses follow from."""
    own = sum((part.by_lens.T @ part.by_lens for part in parts), np.zeros((len(prior),) * 2))
    reduced = own + np.diag(prior) + damping * np.diag(np.diag(own))
    right = sum((part.by_lens.T @ part.error for part in parts), np.zeros(len(prior)))
    rest = []
    for part in parts:
        pose = part.by_pose.T @ part.by_pose
        inverse = np.asarray(np.linalg.inv(pose + damping * np.diag(np.diag(pose))), float)
        shared, pull = part.by_lens.T @ part.by_pose, part.by_pose.T @ part.error
        reduced = reduced - shared @ inverse @ shared.T
        right = right - shared @ inverse @ pull
        rest.append((inverse, shared, pull))
    return reduced, right, rest


def _result(
    start: Lens, values: Array, poses: Array, parts: Sequence[_Part], prior: Array
) -> LensFit:
    matrix = np.array([[values[0], 0, values[2]], [0, values[1], values[3]], [0, 0, 1]])
    lens = Lens(
        start.width, start.height, matrix, values[4:], readout=start.readout, model=start.model
    )
    count = sum(len(part.error) for part in parts)
    variance = _cost(parts) / max(1, count - values.size - poses.size)
    reduced, _, _ = _reduced(parts, prior, 0.0)
    errors = tuple(part.error.reshape(-1, 2) for part in parts)
    covariance = variance * np.asarray(np.linalg.inv(reduced), float)
    return LensFit(lens, poses, errors, covariance)
