"""Find the offset between the clocks of an estimate and of the truth, and say how sure it is.

That the clocks agree is the hypothesis that others must beat. Each is judged by how many of the
poses it explains: those that it leaves out, because the truth has nothing at their time, count
against it as those that do not fit. So a robot that was lost for a part of a lap is not compared
with the next lap, which has no such part and leaves out half.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.features.lab.trajectories.motion_profile import (
    SMOOTHINGS,
    MotionProfile,
    correlations,
    in_gap,
    motion_profile,
)
from app.features.lab.trajectories.time_shift import (
    MEDIANS,
    Channel,
    Course,
    Fit,
    TimeShift,
    places,
    time_shift,
)
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

OVERLAP = 0.5
"""The overlap must be at least this part of the shorter trajectory."""
NEAR = 1.5
"""Offsets that differ by less than this [s] are the same guess."""
PEAKS = 8
"""Number of the highest peaks of the correlation that are compared, at each smoothing."""
PIECE, POSES_IN_PIECE = 5.0, 15
"""Guesses are compared by positions in pieces of this length [s], or of so many poses, each aligned
alone, as odometry drifts and estimates jump."""
COMPARED = 800
"""Number of poses by which guesses are compared."""
ROUNDS = 12
"""How often a guess is improved at most."""
FAR = 5.0
"""A pose off by this many standard deviations is not explained at all."""
FINEST = 1e-3
"""Standard deviation [m] that errors have at least, when guesses are compared."""
MORE = 0.2
"""A guess is better than another if it explains this part more of the poses ..."""
FITS = 0.6
"""... but does not rule out one that explains this part of the poses that it does not leave out."""
SIZED_OVER = 4.0
"""The size of a path is told by how far it gets in this time [s], to which noise adds little."""
USUALLY = 80
"""Percentile of those distances: a robot may stand, an estimate may jump."""
OTHER_SIZE = 1.5
"""If sizes differ by this factor, the estimate has another unit, or none (a single camera)."""
SAME_RUN = 0.8
"""Two trajectories with a smaller correlation are of different runs, unless positions agree.

Trajectories of one run have 0.95 and more (wheel odometry against Vicon; noise of 5 mm). Random
paths reach by chance 0.45 in 40 s and 0.72 in 20 s, but 0.85 in 10 s: paths that short may look
alike.
"""
SAME_PLACES, FOUND_PLACES = 0.25, 0.15
"""Positions agree if half of the poses are off by at most this part of the path's spread, by their
stamps as they are, or at an offset that was searched for. Of 120 pairs of different runs none had
less than 0.29 and 0.22."""
LEAST_OVERLAP = 0.1
"""Stamps that overlap by less than this part of the shorter trajectory say nothing."""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """The time to add to the estimate's stamps to get the truth's clock."""

    shift: TimeShift
    """With its uncertainty."""
    correlation: float
    """Of speed and turn rate at this offset, or of those that are better, in [-1, 1]; low if they
    are not of one run."""
    overlap: float
    """Part of the shorter trajectory that is in both, in [0, 1]."""
    error: float
    """Usual distance [m] of the poses that are not far off, after aligning the pieces: the root
    mean square if they are normal."""
    at_same_places: bool
    """Whether half of the poses or more are at the truth's places, after one alignment of all."""
    by_stamps: bool
    """Whether the stamps overlap as they are, and no other offset is clearly better: then this is
    what is left between the clocks."""
    rivals: tuple[float, ...] = ()
    """Other offsets [s] that explain the poses as well, as a path that is driven twice has: the
    poses alone cannot say which it is."""

    @property
    def seconds(self) -> float:
        """The offset [s]."""
        return self.shift.seconds

    @property
    def choices(self) -> tuple[str, ...]:
        """The offsets [s] to choose from, as options are written."""
        all_ = (0.0 if self.by_stamps else self.seconds, *self.rivals)
        return tuple(f"{seconds:.3f}".rstrip("0").rstrip(".") for seconds in sorted(all_, key=abs))

    @property
    def is_one_run(self) -> bool:
        """Whether the trajectories move alike or are at the same places."""
        return self.correlation >= SAME_RUN or self.at_same_places

    @property
    def correction(self) -> float:
        """What to add to the estimate's stamps [s]: nothing if the offset is not sure."""
        sure = self.shift.is_significant and not (self.by_stamps and self.rivals)
        return self.seconds if sure or not self.by_stamps else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class OffsetHypothesis:
    """A hypothesis about the offset, and what speaks for it."""

    seconds: float
    """The offset [s]."""
    sizes: Array
    """How far each compared pose is off [m]; infinite for those that are left out."""
    sigma: float
    """Standard deviation of the errors in each dimension [m]."""
    overlap: float

    def explained(self, sigma: float) -> float:
        """Return the sum of how well each pose fits, from 0 to 1, if errors have a spread [m]."""
        return float(np.sum(np.maximum(1 - (self.sizes / (FAR * sigma)) ** 2, 0.0)))

    def fits(self, sigma: float) -> bool:
        """Whether it explains most of the poses that it does not leave out."""
        known = np.count_nonzero(np.isfinite(self.sizes))
        return bool(self.overlap >= LEAST_OVERLAP and self.explained(sigma) > FITS * known)


def estimate_clock_offset(truth: Trajectory, estimate: Trajectory) -> ClockOffset:
    """Find the offset between the clocks of two trajectories of one run.

    Guesses are no offset, if the stamps overlap, and where speeds and turn rates, which do not
    depend on the choice of frames, correlate best. Near each, the offset is refined by positions.
    No offset stays unless a guess explains more of the poses. The chosen offset is refined by
    positions, motion and headings (`time_shift`). If either trajectory is planar, the other is
    seen from above. An estimate of another scale, as from a single camera, is first scaled.

    Args:
        truth: with any clock.
        estimate: with any clock.

    Raises:
        TrajectoryError: a trajectory is too short or too long, or they overlap at no offset.
    """
    if truth.planar or estimate.planar:
        truth, estimate = truth.to_planar(), estimate.to_planar()
    planar, course = truth.planar, Course.of(truth)
    size = _size(truth, estimate)
    # A robot that was lost for long gets less far, though it is at the same places else.
    if size != 1 and not _at_same_places(places(course, estimate, COMPARED), 0.0, SAME_PLACES):
        estimate = replace(estimate, positions=size * estimate.positions, lines=None)
    profiles = [
        (motion_profile(truth, planar, smoothing), motion_profile(estimate, planar, smoothing))
        for smoothing in SMOOTHINGS
    ]
    starts, alike, offsets = _starts(profiles)
    few = places(course, estimate, COMPARED)
    as_it_is = (_guess(few, 0.0, near) for near in (_around(0.0), (0.0, 0.0)))
    no_offset = min(
        (guess for guess in as_it_is if guess is not None),
        key=lambda guess: guess.sigma,
        default=None,
    )
    guesses = [_guess(few, start, _around(start)) for start in starts]
    others = [guess for guess in guesses if guess is not None and guess.overlap >= OVERLAP]
    if no_offset is None and not others:
        raise TrajectoryError(
            f"{truth.name} and {estimate.name} overlap too little in time; "
            f"valid is at least {OVERLAP:.0%} of the shorter one"
        )
    chosen, rivals = _judged(no_offset, others)
    shift = time_shift(course, estimate, chosen.seconds, _around(chosen.seconds))
    by_stamps = chosen is no_offset
    if not np.isfinite(shift.deviation):
        shift = replace(shift, seconds=0.0 if by_stamps else chosen.seconds)
    most = SAME_PLACES if by_stamps else FOUND_PLACES
    asked = {0.0, shift.seconds} if by_stamps else {shift.seconds}
    likely = rivals if by_stamps and rivals else (shift.seconds,)
    return ClockOffset(
        shift,
        max(float(alike[np.argmin(np.abs(offsets - seconds))]) for seconds in likely),
        chosen.overlap,
        chosen.sigma * few.dimensions**0.5,
        any(_at_same_places(few, seconds, most) for seconds in asked),
        by_stamps,
        rivals,
    )


def require_same_run(truth: Trajectory, estimate: Trajectory) -> ClockOffset:
    """Return the clock offset of two trajectories that must be of one run.

    Two runs of the same driving program move alike and cannot be told apart.

    Raises:
        TrajectoryError: the trajectories move differently, or there is no offset, or several that
            are as good while the stamps as they are do not overlap.
    """
    offset = estimate_clock_offset(truth, estimate)
    if not offset.is_one_run:
        raise TrajectoryError(
            f"{truth.name} is of another run than {estimate.name}: whatever the clocks, speed and "
            f"turn rate correlate by {offset.correlation:.2f}; valid is {SAME_RUN:g} and more. If "
            "they are of one run, --clock-offset 0 compares them by their stamps"
        )
    if offset.rivals and not offset.by_stamps:
        raise TrajectoryError(
            f"the stamps of {truth.name} and {estimate.name} do not overlap, and the path repeats: "
            f"which lap is it? Valid are --clock-offset {' or '.join(offset.choices)}"
        )
    return offset


def _around(seconds: float) -> tuple[float, float]:
    """Return the bounds [s] of one guess."""
    return seconds - NEAR, seconds + NEAR


def _guess(channel: Channel, start: float, bounds: tuple[float, float]) -> OffsetHypothesis | None:
    spacing = max(channel.course.spacing, float(np.median(np.diff(channel.stamps))))
    fit = Fit.of(channel, max(PIECE, POSES_IN_PIECE * spacing), start, bounds, ROUNDS)
    if fit is None:
        return None
    sizes = np.linalg.norm(fit.errors, axis=1)
    stamps = channel.stamps + fit.seconds
    truth = channel.course.truth.stamps
    inside = float(np.clip(min(truth[-1], stamps[-1]) - max(truth[0], stamps[0]), 0, None))
    shorter = min(truth[-1] - truth[0], stamps[-1] - stamps[0])
    return OffsetHypothesis(fit.seconds, sizes, max(fit.sigma, FINEST), inside / shorter)


def _at_same_places(channel: Channel, seconds: float, most: float) -> bool:
    """Whether half of the poses are off by at most a part of the spread, aligned as a whole.

    The alignment begins with each piece in turn: poses of a robot that was lost would turn it.
    """
    true = channel.true(seconds)[channel.known(seconds)]
    if not len(true):
        return False
    spread = np.median(np.linalg.norm(true - np.median(true, axis=0), axis=1))
    limit = most * spread / MEDIANS[channel.dimensions]
    for stamp in np.arange(channel.stamps[0], channel.stamps[-1], PIECE):
        piece = (channel.stamps >= stamp) & (channel.stamps < stamp + PIECE)
        weights = piece.astype(np.float64)
        fit = Fit.of(channel, np.inf, seconds, (seconds, seconds), weights=weights)
        if fit is not None and fit.sigma <= limit:
            return True
    return False


def _judged(
    no_offset: OffsetHypothesis | None, others: list[OffsetHypothesis]
) -> tuple[OffsetHypothesis, tuple[float, ...]]:
    """Return the guess that holds, and the offsets of others that explain the poses as well."""
    everything = [*([] if no_offset is None else [no_offset]), *others]
    sigma = min(guess.sigma for guess in everything if guess.overlap >= OVERLAP or not others)
    most = max(np.count_nonzero(np.isfinite(guess.sizes)) for guess in everything)

    def explained(guess: OffsetHypothesis) -> float:
        return guess.explained(sigma) / most

    ranked = sorted(others, key=explained, reverse=True)
    holds = no_offset if no_offset is not None else ranked[0]
    better = [guess for guess in ranked if explained(guess) > explained(holds) + MORE]
    better = [guess for guess in better if abs(guess.seconds - holds.seconds) > NEAR]
    if not better and no_offset is not None:
        return no_offset, ()
    best = better[0] if better else ranked[0]
    as_good = [
        guess.seconds
        for guess in ranked
        if explained(guess) > explained(best) - MORE and abs(guess.seconds - best.seconds) > NEAR
    ]
    distinct: list[float] = []
    for seconds in as_good:
        if all(abs(seconds - other) > NEAR for other in distinct):
            distinct.append(seconds)
    if no_offset is not None and (distinct or no_offset.fits(sigma)):
        return no_offset, (best.seconds, *distinct)
    return best, tuple(distinct)


def _starts(
    profiles: list[tuple[MotionProfile, MotionProfile]],
) -> tuple[list[float], Array, Array]:
    """Return offsets [s] to begin at, and the least smoothed correlation (m,) at offsets (m,)."""
    starts: list[float] = []
    finest = None
    for truth, estimate in profiles:
        offsets, alike, overlap = correlations(truth, estimate)
        if finest is None:
            finest = alike
        for merit in (alike, alike * overlap):
            for peak in _peaks(np.where(overlap >= OVERLAP, merit, -2.0)):
                if all(abs(offsets[peak] - start) > 0.2 for start in starts):
                    starts.append(float(offsets[peak]))
    assert finest is not None
    return starts, finest, offsets


def _peaks(merit: Array) -> NDArray[np.int64]:
    """Return the highest peaks."""
    padded = np.concatenate([[-2.0], merit, [-2.0]])
    peaks = np.flatnonzero((merit >= padded[:-2]) & (merit > padded[2:]) & (merit > -2))
    highest: NDArray[np.int64] = peaks[np.argsort(-merit[peaks], kind="stable")[:PEAKS]]
    return highest


def _size(truth: Trajectory, estimate: Trajectory) -> float:
    """Return the factor that scales an estimate to the truth; 1 unless the sizes differ much."""
    usual, theirs = (_usual_distance(item) for item in (truth, estimate))
    if min(usual, theirs) <= 0 or max(usual / theirs, theirs / usual) < OTHER_SIZE:
        return 1.0
    return usual / theirs


def _usual_distance(trajectory: Trajectory) -> float:
    """Return how far a trajectory usually gets [m] in a time."""
    over = min(SIZED_OVER, trajectory.duration / 2)
    stamps = trajectory.stamps
    starts = np.linspace(stamps[0], stamps[-1] - over, 4 * COMPARED)
    starts = starts[~in_gap(trajectory, starts) & ~in_gap(trajectory, starts + over)]
    if not len(starts):
        return 0.0
    first, last = (
        np.column_stack([np.interp(asked, stamps, axis) for axis in trajectory.positions.T])
        for asked in (starts, starts + over)
    )
    return float(np.percentile(np.linalg.norm(last - first, axis=1), USUALLY))
