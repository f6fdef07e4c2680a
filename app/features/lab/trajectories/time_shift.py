"""Estimate how late one trajectory is against another of the same run, and how sure that is.

With a clock that is late, poses are off along the way by speed times lateness. So the truth is
asked at the estimate's stamps plus a shift, the estimate is aligned with it, and what is left,
times the truth's velocity, says how to change the shift (Gauss-Newton). Headings are compared
likewise, with the turn rate in place of the velocity; and so is motion, the distances and turns
within a short time, to which drift adds only a constant. Poses that are far off, as those of a
robot that was lost, weigh little (Geman and McClure).

What is solved for is where the errors have no part along the velocity, not where they are least:
the least error is biased, as truth that is interpolated has less noise between its poses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.stats import norm, t

from app.features.lab.trajectories.motion_profile import in_gap, longest_step
from app.trajectories.trajectory import Trajectory
from robot.geometry import Array, wrap_angle

SPANS = (0.5, 2.0)
"""Motion is what happens within these times [s]."""
LONGER = 2.0
"""With fewer poses, motion may take longer by this factor."""
CLEARLY = 0.5
"""Motion counts instead of positions if its uncertainty is below this part."""
SURE = 4.0
"""A shift is significant from so many standard deviations on. That is more than three, as how the
errors hang together is itself only estimated."""
ROUNDS = 30
STEP = 0.3
"""A round changes the shift by at most this [s]."""
SETTLED = 1e-6
"""A change below this [s] ends the search."""
FAR = 3.0
"""A pose off by this many standard deviations weighs a quarter."""
LOOSE = (8.0, 4.0, 2.0)
"""Factors of FAR in the first rounds, while the alignment may still be wrong."""
MEDIANS = {1: 0.6745, 2: 1.1774, 3: 1.5382}
"""Median length of normal errors in so many dimensions, in standard deviations."""
LEAST = 1e-6
"""Errors count as at least this large [m, rad]."""
BATCH = 0.5
"""Errors within this time [s] are summed before it is asked how they hang together."""
MOMENT = 1.0
"""Poses within this time [s] tell the time by the same bend of the path."""
REACH = 0.1
"""Velocities are over at least this time before and after [s]."""
FINEST = 1e-4
"""Standard deviation of stamps themselves [s], as files round them."""
UNLIKE = 0.5
"""A channel is left out if its errors exceed this part of the path's own spread."""
COARSE = 0.04
"""Of truth with more time between poses [s] it is asked what the interpolation costs."""
POSES_COMPARED = 20_000
FEWEST = 3
"""Smallest number of poses that tell anything."""


@dataclass(frozen=True, slots=True)
class TimeShift:
    """A time to add to the estimate's stamps, and how sure it is."""

    seconds: float
    """[s]."""
    deviation: float
    """Standard deviation [s]; infinite if the motion does not tell the time."""
    freedom: float
    """Degrees of freedom of the deviation: few if the errors hang together."""

    @property
    def interval(self) -> tuple[float, float]:
        """The bounds [s] that hold the true shift in 95 % of cases."""
        reach = self.reach()
        return self.seconds - reach, self.seconds + reach

    @property
    def is_significant(self) -> bool:
        """Whether it exceeds SURE standard deviations (with few degrees of freedom, more)."""
        return abs(self.seconds) > self.reach(float(norm.cdf(SURE)))

    def contradicted_by(self, other: TimeShift) -> TimeShift:
        """Return the same, less sure by as much as another one contradicts it."""
        if not math.isfinite(self.deviation + other.deviation):
            return self
        return replace(self, deviation=self.deviation * max(self.apart_from(other), 1.0))

    def apart_from(self, other: TimeShift) -> float:
        """Return how many standard deviations another one is apart from this."""
        return abs(self.seconds - other.seconds) / math.hypot(self.deviation, other.deviation)

    def reach(self, part: float = 0.975) -> float:
        """Return how far [s] the true shift is above this one at most, in a part of the cases."""
        if not math.isfinite(self.deviation):
            return math.inf
        return self.deviation * float(t.ppf(part, max(self.freedom, 1.0)))


UNTOLD = TimeShift(0.0, math.inf, 1.0)


class Quantity(Enum):
    """What is compared."""

    PLACES = "positions"
    HEADINGS = "headings"
    DISTANCES = "distances within a time"
    TURNS = "turns within a time"


@dataclass(frozen=True, eq=False)
class Course:
    """A true trajectory at any time."""

    truth: Trajectory
    places: CubicSpline
    headings: CubicSpline
    """Unwrapped [rad]."""
    spacing: float
    """Usual time between poses [s]."""
    longest: float
    """Longest time between poses that is no gap [s]."""

    @classmethod
    def of(cls, truth: Trajectory) -> Course:
        """Return the course through the poses of a trajectory."""
        truth = truth.without_repeats()
        spacing = float(np.median(np.diff(truth.stamps)))
        return cls(truth, *_splines(truth, np.arange(len(truth))), spacing, longest_step(truth))

    def coarser(self) -> Course:
        """Return the same through every second pose only."""
        kept = np.append(np.arange(0, len(self.truth) - 1, 2), len(self.truth) - 1)
        places, headings = _splines(self.truth, kept)
        return replace(self, places=places, headings=headings)


def _splines(truth: Trajectory, kept: NDArray[np.int64]) -> tuple[CubicSpline, CubicSpline]:
    stamps, width = truth.stamps[kept], 2 if truth.planar else 3
    headings = np.unwrap(truth.poses[:, 2])[kept]
    return CubicSpline(stamps, truth.positions[kept, :width]), CubicSpline(stamps, headings)


@dataclass(frozen=True, eq=False)
class Channel:
    """One quantity of both trajectories."""

    quantity: Quantity
    course: Course
    stamps: Array
    """Of the estimate (n,) [s]."""
    values: Array
    """Of the estimate (n, d) [m or rad]."""
    spans: Array | float = 0.0
    """Of motions the times (n,) that they take [s]."""

    @property
    def dimensions(self) -> int:
        """2 or 3 for positions, 1 for all else."""
        return int(self.values.shape[1])

    def known(self, shift: float) -> NDArray[np.bool_]:
        """Return where the truth is known (n,) if the estimate is shifted by a time [s]."""
        asked, course = self.stamps + shift, self.course
        known = ~in_gap(course.truth, asked, course.longest)
        if self.quantity in (Quantity.DISTANCES, Quantity.TURNS):
            known &= ~in_gap(course.truth, asked + self.spans, course.longest)
        return known

    def true(self, shift: float) -> Array:
        """Return the truth's values (n, d) if the estimate is shifted by a time [s]."""
        asked, course = self.stamps + shift, self.course
        match self.quantity:
            case Quantity.PLACES:
                values = course.places(asked)
            case Quantity.HEADINGS:
                values = course.headings(asked)[:, None]
            case Quantity.DISTANCES:
                ways = course.places(asked + self.spans) - course.places(asked)
                values = np.linalg.norm(ways, axis=1, keepdims=True)
            case Quantity.TURNS:
                turns = course.headings(asked + self.spans) - course.headings(asked)
                values = turns[:, None]
        return np.asarray(values, dtype=np.float64)

    def rates(self, shift: float, reach: float) -> Array:
        """Return the truth's rates of change (n, d), over a time before and after [s]."""
        return (self.true(shift + reach) - self.true(shift - reach)) / (2 * reach)

    @property
    def reach(self) -> float:
        """Rates are over this time before and after [s], so that noise does not matter."""
        return max(REACH, self.course.spacing)


def places(course: Course, estimate: Trajectory, most: int = POSES_COMPARED) -> Channel:
    """Return the positions of two trajectories; of a longer estimate those of so many poses."""
    few = slice(None, None, (len(estimate) - 1) // most + 1)
    width = 2 if course.truth.planar else 3
    return Channel(Quantity.PLACES, course, estimate.stamps[few], estimate.positions[few, :width])


def _poses(course: Course, estimate: Trajectory) -> list[Channel]:
    """Return positions, and headings if both are planar."""
    where = places(course, estimate)
    if not course.truth.planar:
        return [where]
    few = slice(None, None, (len(estimate) - 1) // POSES_COMPARED + 1)
    headings = estimate.poses[few, 2][:, None]
    return [where, Channel(Quantity.HEADINGS, course, where.stamps, headings)]


def _motions_within(course: Course, estimate: Trajectory, span: float) -> list[Channel]:
    """Return distances within a time [s], and turns if both are planar."""
    stamps = estimate.stamps
    later = np.searchsorted(stamps, stamps + span - 1e-9)
    first = np.flatnonzero(later < len(stamps))
    first = first[stamps[later[first]] - stamps[first] <= LONGER * span]
    first = first[:: len(first) // POSES_COMPARED + 1]
    last = later[first]
    if len(first) < FEWEST:
        return []
    spans = stamps[last] - stamps[first]
    ways = estimate.positions[last] - estimate.positions[first]
    distances = np.linalg.norm(ways, axis=1, keepdims=True)
    result = [Channel(Quantity.DISTANCES, course, stamps[first], distances, spans)]
    if course.truth.planar:
        headings = estimate.poses[:, 2]
        turns = wrap_angle(headings[last] - headings[first])[:, None]
        result.append(Channel(Quantity.TURNS, course, stamps[first], turns, spans))
    return result


def time_shift(
    course: Course, estimate: Trajectory, start: float, bounds: tuple[float, float]
) -> TimeShift:
    """Return the shift near a first guess [s], within bounds [s].

    Positions and headings tell it together; distances and turns tell it together, too, and count
    instead where they are clearly surer, as those of odometry that drifts. Where what is compared
    contradicts itself, the uncertainty is as large as the contradiction (Birge).
    """
    best = _shift_by(_poses(course, estimate), start, bounds)
    others = [_shift_by(_motions_within(course, estimate, span), start, bounds) for span in SPANS]
    other = min(others, key=TimeShift.reach)
    if other.reach() < CLEARLY * best.reach():
        best, other = other, best
    return best.contradicted_by(other)


def _shift_by(channels: list[Channel], start: float, bounds: tuple[float, float]) -> TimeShift:
    """Return the shift that channels with independent errors tell together."""
    shifts = [_channel_shift(channel, start, bounds) for channel in channels]
    finite = [shift for shift in shifts if math.isfinite(shift.deviation)]
    if len(finite) < 2:
        return finite[0] if finite else UNTOLD
    first, second = finite
    weights = np.array([first.deviation, second.deviation]) ** -2.0
    seconds = float(weights @ [first.seconds, second.seconds] / weights.sum())
    # Welch and Satterthwaite.
    freedom = weights.sum() ** 2 / np.sum(weights**2 / [first.freedom, second.freedom])
    deviation = float(weights.sum() ** -0.5) * max(first.apart_from(second), 1.0)
    return TimeShift(seconds, deviation, float(freedom))


def _channel_shift(channel: Channel, start: float, bounds: tuple[float, float]) -> TimeShift:
    """Return the shift that a channel tells, with what the truth's interpolation adds."""
    fit = Fit.of(channel, math.inf, start, bounds)
    shift = fit.shift() if fit else UNTOLD
    if channel.course.spacing <= COARSE or not math.isfinite(shift.deviation):
        return shift
    # Where the path bends sharply, half of the truth's poses err by at least twice as much.
    coarser = replace(channel, course=channel.course.coarser())
    half = Fit.of(coarser, math.inf, shift.seconds, bounds)
    cost = abs(half.seconds - shift.seconds) / 2 if half else math.inf
    return replace(shift, deviation=math.hypot(shift.deviation, cost))


@dataclass(frozen=True, eq=False)
class Fit:
    """A channel, aligned in pieces at the shift that suits it."""

    channel: Channel
    seconds: float
    """The shift [s]."""
    errors: Array
    """(n, d) truth minus aligned estimate; infinite where the truth is not known."""
    sigma: float
    """Standard deviation of the errors of poses that are not far off, in each dimension."""
    starts: NDArray[np.int64]
    """The first pose of each piece."""

    @classmethod
    def of(
        cls,
        channel: Channel,
        length: float,
        start: float,
        bounds: tuple[float, float],
        rounds: int = ROUNDS,
        weights: Array | None = None,
    ) -> Fit | None:
        """Fit the shift; None if fewer than three poses overlap, or nothing moves.

        Args:
            length: of the pieces [s].
            start: first guess [s].
            bounds: where to look [s]; equal ones fix the shift.
            rounds: how often to improve it at most.
            weights: of the poses (n,) at the beginning, if it is known which are far off.
        """
        pieces = _pieces(channel.stamps, length)
        loose = LOOSE if weights is None else ()
        seconds, weights = start, np.ones(len(channel.stamps)) if weights is None else weights
        for number in range(rounds):
            known = channel.known(seconds)
            if np.count_nonzero(known) < FEWEST:
                return None
            # Far off from here, no weight at all would be left to begin again with.
            used = np.where(known, np.maximum(weights, 1e-9), 0.0)
            errors = _aligned_errors(channel, seconds, used, pieces)
            sizes = np.linalg.norm(errors, axis=1)
            sigma = max(float(np.median(sizes[known])) / MEDIANS[channel.dimensions], LEAST)
            far = FAR * sigma * (loose[number] if number < len(loose) else 1.0)
            weights = np.where(known, (1 + (sizes / far) ** 2) ** -2.0, 0.0)
            if bounds[0] == bounds[1] and number >= len(LOOSE) + 5:
                break
            score, slope, _ = _score(channel, seconds, errors, weights, pieces)
            if not abs(slope) > 0:
                break
            step = float(np.clip(-score.sum() / slope, -STEP, STEP))
            previous, seconds = seconds, float(np.clip(seconds + step, *bounds))
            if abs(seconds - previous) < SETTLED and number > len(LOOSE):
                break
        errors = np.where(known[:, None], errors, np.inf)
        return cls(channel, seconds, errors, sigma, pieces)

    def shift(self) -> TimeShift:
        """Return the shift with its deviation, from the errors that are left."""
        known = np.isfinite(self.errors[:, 0])
        errors = np.where(known[:, None], self.errors, 0.0)
        sizes, far = np.linalg.norm(errors, axis=1), FAR * self.sigma
        weights = np.where(known, (1 + (sizes / far) ** 2) ** -2.0, 0.0)
        if self._is_unlike(known):
            return UNTOLD
        score, slope, telling = _score(
            self.channel, self.seconds, errors, weights, self.starts, far
        )
        if not slope > 0:
            return UNTOLD
        used = known & (weights > 0.1)
        parameters = 1 + len(self.starts) * {1: 1, 2: 3, 3: 6}[self.channel.dimensions]
        numbers = np.count_nonzero(used) * self.channel.dimensions
        if numbers <= parameters + 1:
            return UNTOLD
        variance, freedom = _variance_of_sum(self.channel.stamps[known], score[known])
        few = _moments(self.channel.stamps, telling) - 1
        freedom = min(freedom, few, float(numbers - parameters))
        deviation = math.sqrt(variance * numbers / (numbers - parameters)) / slope
        return TimeShift(self.seconds, math.hypot(deviation, FINEST), freedom)

    def _is_unlike(self, known: NDArray[np.bool_]) -> bool:
        """Whether the errors are so large that this is not the path."""
        true = self.channel.true(self.seconds)[known]
        spread = np.sqrt(np.mean((true - true.mean(axis=0)) ** 2))
        return self.sigma > UNLIKE * float(spread)


def _pieces(stamps: Array, length: float) -> NDArray[np.int64]:
    """Return where pieces of equal duration start, at least a length [s] unless there is one."""
    elapsed = stamps - stamps[0]
    count = max(int(elapsed[-1] / length), 1)
    piece = np.minimum((elapsed * count / elapsed[-1]).astype(np.int64), count - 1)
    return np.flatnonzero(np.diff(piece, prepend=-1))


def _spread_out(of_pieces: Array, starts: NDArray[np.int64], count: int) -> Array:
    """Repeat the values of pieces (p, ...) for each of their poses (n, ...)."""
    spread: Array = np.repeat(of_pieces, np.diff(np.append(starts, count)), axis=0)
    return spread


def _aligned_errors(
    channel: Channel, shift: float, weights: Array, starts: NDArray[np.int64]
) -> Array:
    """Return truth minus estimate (n, d) after aligning each piece by weights (n,)."""
    true, values, count = channel.true(shift), channel.values, len(channel.stamps)
    total = np.maximum(np.add.reduceat(weights, starts), 1e-300)[:, None]

    def centred(points: Array) -> Array:
        middles = np.add.reduceat(weights[:, None] * points, starts) / total
        moved: Array = points - _spread_out(middles, starts, count)
        return moved

    if channel.quantity is Quantity.DISTANCES:
        return centred(true - values)
    if channel.dimensions == 1:
        turns = np.exp(1j * (true - values)) * weights[:, None]
        mean = _spread_out(np.angle(np.add.reduceat(turns, starts)), starts, count)
        wrapped: Array = wrap_angle(true - values - mean)
        return wrapped
    true, values = centred(true), centred(values)
    products = weights[:, None, None] * true[:, :, None] * values[:, None, :]
    u, _, v = np.linalg.svd(np.add.reduceat(products, starts))
    # A reflection is not a rigid motion: flip the weakest axis instead (Umeyama 1991).
    u[:, :, -1] *= np.sign(np.linalg.det(u) * np.linalg.det(v))[:, None]
    turned: Array = np.einsum("nij,nj->ni", _spread_out(u @ v, starts, count), values)
    return true - turned


def _score(
    channel: Channel,
    shift: float,
    errors: Array,
    weights: Array,
    starts: NDArray[np.int64],
    far: float = math.inf,
) -> tuple[Array, float, Array]:
    """Return the part of each error along the velocity (n,), and what a second changes their sum.

    Velocities count only as far as an alignment of the pieces does not do the same; their weighted
    squares (n,), how much each pose tells of the time, are returned, too.

    Args:
        far: where weights are a quarter, if the change is to include that of the weights.
    """
    free = _without_alignment(channel, shift, weights, starts)
    along = np.sum(free * errors, axis=1)
    rates = channel.rates(shift, channel.reach / 2)
    slope = np.sum(weights * np.sum(free * rates, axis=1))
    if math.isfinite(far):
        fall = -4 / far**2 * weights**1.5
        slope += np.sum(fall * along * np.sum(errors * rates, axis=1))
    return weights * along, float(slope), weights * np.sum(free**2, axis=1)


def _without_alignment(
    channel: Channel, shift: float, weights: Array, starts: NDArray[np.int64]
) -> Array:
    """Return the velocities (n, d) minus what moves and turns of the pieces explain of them."""
    rates, count = channel.rates(shift, channel.reach), len(channel.stamps)
    basis = _free_motions(channel, shift)
    weighted = weights[:, None, None] * basis
    normal = np.add.reduceat(np.einsum("ndk,ndl->nkl", weighted, basis), starts)
    right = np.add.reduceat(np.einsum("ndk,nd->nk", weighted, rates), starts)
    solved = np.einsum("pkl,pl->pk", np.linalg.pinv(normal, rcond=1e-10, hermitian=True), right)
    free: Array = rates - np.einsum("ndk,nk->nd", basis, _spread_out(solved, starts, count))
    return free


def _free_motions(channel: Channel, shift: float) -> Array:
    """Return what small moves and turns change (n, d, k)."""
    count, width = len(channel.stamps), channel.dimensions
    moves = np.broadcast_to(np.eye(width), (count, width, width))
    if width == 1:
        return moves
    true = channel.true(shift)
    true = true - true.mean(axis=0)
    if width == 2:
        turns = np.stack([-true[:, 1], true[:, 0]], axis=1)[:, :, None]
    else:
        turns = np.stack([np.cross(axis, true) for axis in np.eye(3)], axis=2)
    return np.concatenate([moves, turns], axis=2)


def _moments(stamps: Array, telling: Array) -> float:
    """Return how many moments tell the time: few, where a path only bends now and then.

    Args:
        stamps: (n,) [s].
        telling: how much each pose tells (n,).
    """
    moment = np.floor((stamps - stamps[0]) / MOMENT)
    sums = np.add.reduceat(telling, np.flatnonzero(np.diff(moment, prepend=-1.0)))
    return float(sums.sum() ** 2 / np.sum(sums**2))


def _variance_of_sum(stamps: Array, score: Array) -> tuple[float, float]:
    """Return the variance of the sum of scores (n,), and its degrees of freedom.

    Errors of neighbouring poses hang together, so the scores are summed in batches, and the
    covariances of near batches are added: after a first-order prediction, by Newey and West (1987)
    with Andrews and Monahan's prewhitening (1992).
    """
    batch = np.floor((stamps - stamps[0]) / BATCH)
    starts = np.flatnonzero(np.diff(batch, prepend=-1.0))
    sums = np.add.reduceat(score, starts)
    count = len(sums)
    if count < 4:
        return float(np.sum(score**2)) * 4, 1.0
    square = float(np.sum(sums**2))
    if square <= 0:
        return 0.0, float(count)
    together = float(np.sum(sums[1:] * sums[:-1])) / square
    together = float(np.clip(together + (1 + 3 * together) / count, 0.0, 0.9))
    rest = sums[1:] - together * sums[:-1]
    lags = int(4 * (count / 100) ** (2 / 9))
    variance = float(rest @ rest)
    for lag in range(1, min(lags, len(rest) - 1) + 1):
        variance += 2 * (1 - lag / (lags + 1)) * float(rest[lag:] @ rest[:-lag])
    variance = max(variance, 0.5 * float(rest @ rest)) / (1 - together) ** 2
    variance *= count / len(rest)
    return variance, max(count * (1 - together) / (1 + together) - 1, 1.0)
