"""Calibrates a lens by the pictures that are of use, with the simplest model that is good enough.

Which model is judged by pictures that it was not adjusted to: with more coefficients the fit always
gets better, the lens does not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

import numpy as np

from robot.calibration.lens.adjustment import (
    COEFFICIENT_SD,
    LensFit,
    board_pose,
    first_fit,
    fit_lens,
    held_out_errors,
    rms_of,
)
from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import bare_corners
from robot.calibration.lens.sighting import Sighting
from robot.camera import CameraError, Lens
from robot.errors import BrickPoseError
from robot.estimation.fit_quality import FitQuality, correlation_of, overruns
from robot.geometry import Array

MODELS = ("plumb_bob", "equidistant", "rational_polynomial")
"""The models of lenses, the simplest and best known first."""
LEAST_PICTURES = 6
"""With fewer pictures, little is left to judge a lens by."""
FOLDS = 5
"""Number of parts in which pictures are held out."""
WORSE = 1.05
"""A simpler model is as good if its error is at most this many times as large: models that differ
by less in held-out pictures differ by 20 to 147 px in corners where no board was."""
EXACT_PX = 0.01
"""... or larger by at most this: no corner is found more exactly than to some hundredths [px]."""
ALIKE = 1.2
"""Models whose errors differ by less cannot be told apart for certain."""
LARGEST_TERM = 1.0
"""A model counts only where no other fits, if one term of its distortion moves the picture's corner
by more than this share of its distance from the centre: terms that large cancel each other where
boards were, and nowhere else. Of ordinary lenses they are below 0.3, of fisheyes below 0.9; in the
rational model, numerator and denominator cancel, so it is not judged."""
POOR_PX = 2.0
"""A lens that is farther off in held-out pictures is refused [px]."""
FAR_OFF, FAR_OFF_PX = 3.0, 0.5
"""A picture is refused if its error is this many times the usual one, and at least this large
[px]."""
MIRRORED = 0.7
"""It is mirrored if, turned round, it errs by less than this share."""
BLURRED, BLURRED_PX = 1.6, 4.0
"""A picture is blurred if its edges are this many times as wide as usual, and at least this wide
[px]."""
REPEATED = 0.005
"""Pictures are the same if their corners differ by less than this share of the diagonal."""


class LensError(BrickPoseError, ValueError):
    """The pictures tell no lens; the message says why, and what would."""


@dataclass(frozen=True, eq=False)
class Rating:
    """How far corners lie off, in pictures that the model was not adjusted to."""

    model: str
    held_out: Array = field(repr=False)
    """(k,) mean square error of each picture [px²]; inf where the model fails."""
    fit: LensFit = field(repr=False)
    """Of all pictures."""

    @property
    def rms(self) -> float:
        """Root mean square [px]."""
        return math.sqrt(float(self.held_out.mean()))


@dataclass(frozen=True)
class LensCalibration:
    """A lens, and what it was measured by."""

    chosen: Rating
    ratings: tuple[Rating, ...]
    """Of all models."""
    seen: Mapping[str, Sighting] = field(repr=False)
    """What counts, by the picture's name."""
    refused: Mapping[str, str]
    """Why the other pictures do not count."""

    @property
    def lens(self) -> Lens:
        """The lens."""
        return self.chosen.fit.lens

    @property
    def sd(self) -> Array:
        """(p,) standard deviations of fx, fy, cx, cy and the coefficients."""
        return self.quality.interval_factor * self.chosen.fit.sd

    @property
    def quality(self) -> FitQuality:
        """How well the lens fits: what is expected is what it leaves in its own pictures."""
        fit = self.chosen.fit
        coefficients = tuple(fit.lens.parameters)[4:]
        most = np.full(len(coefficients), COEFFICIENT_SD)
        overrun = overruns(fit.lens.distortion, most, coefficients)
        bare = tuple(bare_corners(list(self.seen.values())))
        own = max(fit.rms, EXACT_PX)
        alike = correlation_of(np.concatenate([errors.ravel("F") for errors in fit.errors]))
        return FitQuality(self.chosen.rms / own, fit.converged, alike, overrun, bare)


def calibrate_lens(
    seen: Mapping[str, Sighting], board: Board, refused: Mapping[str, str]
) -> LensCalibration:
    """Calibrate a lens.

    Args:
        seen: the board in each picture, by the picture's name.
        board: the board.
        refused: why other pictures do not count.

    Raises:
        LensError: too few pictures are of use, or no lens fits them.
    """
    refused, seen = dict(refused), dict(seen)
    for name, reason in of_no_use(seen, board).items():
        refused[name] = reason
        del seen[name]
    while True:
        _require(seen, refused)
        sightings = list(seen.values())
        ratings = _ratings(sightings, board)
        chosen = choice(ratings)
        name, reason = _worst(seen, chosen, board)
        if not reason:
            return LensCalibration(chosen, tuple(ratings), seen, refused)
        refused[name] = reason
        del seen[name]


def choice(ratings: Sequence[Rating]) -> Rating:
    """Return the first that is as good as the best, within the noise of the comparison."""
    sound = [rating for rating in ratings if _is_bounded(rating.fit.lens)]
    if any(rating.rms < POOR_PX for rating in sound):
        ratings = sound
    best = min(ratings, key=lambda rating: rating.rms)
    if not best.rms < POOR_PX:
        raise LensError(
            f"no lens fits the pictures: in held-out ones corners lie {best.rms:.1f} px off; do "
            "the squares have the given size, is the board flat, and are all pictures of one "
            "camera at one zoom?"
        )
    for rating in ratings:
        more = rating.held_out - best.held_out
        error = float(np.std(more)) / math.sqrt(len(more)) if np.isfinite(more).all() else 0.0
        as_good = rating.rms < max(WORSE * best.rms, best.rms + EXACT_PX)
        if as_good or more.mean() < error:
            return rating
    return best


def _is_bounded(lens: Lens) -> bool:
    if lens.model == "rational_polynomial":
        return True
    k = lens.distortion
    radial = k if lens.model == "equidistant" else k[[0, 1, 4]]
    corners = np.array(list(product((0, lens.width - 1), (0, lens.height - 1))), np.float64)
    away = (corners - lens.matrix[:2, 2]) / lens.matrix[[0, 1], [0, 1]]
    farthest = float(np.hypot(*away.T).max())
    terms = np.abs(radial) * farthest ** (2 * np.arange(1, len(radial) + 1))
    return bool((terms < LARGEST_TERM).all())


def extrapolated(ratings: Sequence[Rating], chosen: Rating) -> float:
    """Return by how much the other models that fit as well differ in the picture's corners [px]."""
    lens = chosen.fit.lens
    corners = np.array(list(product((0, lens.width - 1), (0, lens.height - 1))), np.float64)
    rays = lens.unproject(corners)
    apart = [0.0]
    for rating in ratings:
        if rating.rms < ALIKE * chosen.rms and _is_bounded(rating.fit.lens):
            distances = np.hypot(*(rating.fit.lens.project(rays) - corners).T)
            apart += distances[np.isfinite(distances)].tolist()
    return max(apart)


def of_no_use(seen: Mapping[str, Sighting], board: Board) -> dict[str, str]:
    """Return the pictures of another size, blurred beside the others, or repeated; and why."""
    sizes = [sighting.size for sighting in seen.values()]
    usual = max(dict.fromkeys(sizes), key=sizes.count) if sizes else (0, 0)
    widths = [sighting.edge_width for sighting in seen.values() if sighting.size == usual]
    limit = max(BLURRED * float(np.median(widths)), BLURRED_PX) if widths else 0.0
    result: dict[str, str] = {}
    kept: dict[str, Sighting] = {}
    for name, sighting in seen.items():
        width, height = sighting.size
        if sighting.size != usual:
            result[name] = f"of {width} x {height} px; most are of {usual[0]} x {usual[1]} px"
        elif sighting.edge_width > limit:
            result[name] = (
                f"blurred: edges are {sighting.edge_width:.1f} px wide, "
                f"in the others {np.median(widths):.1f} px"
            )
        elif twin := next(
            (old for old in kept if _apart(kept[old], sighting, board) < REPEATED), None
        ):
            result[name] = f"repeated: the board is where it is in {twin}"
        else:
            kept[name] = sighting
    return result


def _apart(one_view: Sighting, other: Sighting, board: Board) -> float:
    """Return the mean distance between the corners of both, as a share of the diagonal."""
    last = len(board.corners) - 1
    ways = [other.places, {last - number: place for number, place in other.places.items()}]
    if board.kind != "chessboard":
        del ways[1:]  # the markers tell which side of the board is up
    result = math.inf
    for places in ways:
        common = one_view.places.keys() & places.keys()
        if len(common) >= 0.8 * max(len(one_view.ids), len(other.ids)):
            steps = [one_view.places[number] - places[number] for number in common]
            apart = float(np.linalg.norm(steps, axis=1).mean()) / math.hypot(*one_view.size)
            result = min(result, apart)
    return result


def _require(seen: Mapping[str, Sighting], refused: Mapping[str, str]) -> None:
    if len(seen) >= LEAST_PICTURES:
        return
    reasons = "; ".join(f"{name}: {reason}" for name, reason in list(refused.items())[:4])
    raise LensError(
        f"{len(seen)} pictures of {len(seen) + len(refused)} are of use; valid are "
        f"{LEAST_PICTURES} or more" + (f" ({reasons})" if reasons else "")
    )


def _ratings(seen: Sequence[Sighting], board: Board) -> list[Rating]:
    result = []
    for model in MODELS:
        try:
            fit = first_fit(model, seen, board)
        except CameraError:
            continue
        result.append(Rating(model, _held_out(fit, seen, board), fit))
    if not result:
        raise LensError(
            "no lens fits the pictures: do the squares have the given size, is the board flat?"
        )
    return result


def _held_out(fit: LensFit, seen: Sequence[Sighting], board: Board) -> Array:
    """Return the mean square error (k,) of each picture, by a lens of the others."""
    result = np.full(len(seen), np.inf)
    if not _shows_all(fit.lens):
        return result
    folds = min(FOLDS, len(seen))
    for fold in range(folds):
        others = [sighting for place, sighting in enumerate(seen) if place % folds != fold]
        try:
            lens = fit_lens(fit.lens, others, board).lens
            for place in range(fold, len(seen), folds):
                errors = held_out_errors(lens, seen[place], board, fit.poses[place])
                result[place] = (errors**2).sum(axis=1).mean()
        except (CameraError, np.linalg.LinAlgError):
            continue  # it stays infinite: without a part of the pictures the model fails
    return np.where(np.isfinite(result), result, np.inf)


def _shows_all(lens: Lens) -> bool:
    """Return whether the lens knows a direction for the middle of each side of the picture."""
    right, bottom = lens.width - 1.0, lens.height - 1.0
    middle = right / 2, bottom / 2
    sides = [(0, middle[1]), (right, middle[1]), (middle[0], 0), (middle[0], bottom)]
    return bool(np.isfinite(lens.unproject(np.array(sides))).all())


def _worst(seen: Mapping[str, Sighting], rating: Rating, board: Board) -> tuple[str, str]:
    """Return the picture that fits the others least, and why it does not count; or no reason."""
    lens = rating.fit.lens
    off_px = {name: _error(lens, sighting, board) for name, sighting in seen.items()}
    turned = {name: _error(lens, seen[name].mirrored(board), board) for name in seen}
    share = {name: turned[name] / off_px[name] for name in seen}
    for name, old in _mirrored_twins(seen, board):
        copy, original = sorted((name, old), key=share.__getitem__)
        return copy, f"mirrored: turned round, it is {original}"
    name = min(seen, key=share.__getitem__)
    if turned[name] < MIRRORED * off_px[name]:
        return name, "mirrored: turned round, it fits the others"
    errors = np.sqrt(rating.held_out)
    place, usual = int(np.argmax(errors)), float(np.median(errors))
    if errors[place] < max(FAR_OFF * usual, FAR_OFF_PX):
        return "", ""
    return list(seen)[place], (
        f"its corners lie {errors[place]:.1f} px off a lens that fits the others to {usual:.1f} "
        "px: another camera or zoom, a board that is not flat, or mirrored"
    )


def _mirrored_twins(seen: Mapping[str, Sighting], board: Board) -> Iterator[tuple[str, str]]:
    """Yield pairs of pictures one of which is the other, turned round."""
    for (name, sighting), (old, other) in combinations(seen.items(), 2):
        if _apart(sighting.mirrored(board), other, board) < REPEATED:
            yield name, old


def _error(lens: Lens, sighting: Sighting, board: Board) -> float:
    pose = board_pose(lens, sighting, board)
    return rms_of([held_out_errors(lens, sighting, board, pose)])
