"""Drives with odometry and truth, their motions and twists, and the correction of odometry."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from app.features.lab.model_fits.likelihood import FitError
from robot.driving.differential_drive import WheelMultipliers
from robot.geometry import Array, compose, wrap_angle

STRAIGHT = 1e-4
"""Below this turn [rad] the Taylor series is used."""
STEP = 1 / 30
"""Duration of a step [s]: the filter moves its poses once per picture. The alphas are valid for
this step only, as the variance that they give to a metre grows with the length of its steps."""
MAX_GAP = 0.2
"""Truth is not interpolated over longer gaps [s]."""


@dataclass(frozen=True, slots=True)
class DriveCorrection:
    """Correction of odometry's systematic errors.

    From a distance D and a turn W by odometry it computes

        W' = turn W + curvature D
        D' = distance D + (curvature track^2 / 4) (distance / turn) W

    This is the same as a factor on the path of each wheel and another track: with the paths
    L = D - track W / 2 and R = D + track W / 2 and the multipliers m_l, m_r and m_b,
    D' = (m_l L + m_r R) / 2 and W' = (m_r R - m_l L) / (m_b track).
    """

    distance: float = 1.0
    """True distance divided by that of odometry."""
    turn: float = 1.0
    """True turn divided by that of odometry."""
    curvature: float = 0.0
    """True turn per distance where odometry goes straight [rad/m]."""
    track: float = 0.0
    """Distance between the wheels that odometry assumes [m]. If it is not known, it is 0, and the
    last term, of less than a millimetre per radian, is left out."""

    def corrected(self, steps: Array) -> Array:
        """Return corrected steps (n, 3) [m, m, rad] of odometry; each is an arc."""
        x, y, turn = np.moveaxis(twists_of(steps), -1, 0)
        # Unequal wheels turn a robot about a point beside the middle between them.
        aside = self.curvature * self.track**2 / 4 * self.distance / self.turn
        ahead = self.distance * x + aside * turn
        return motions_of(
            np.stack([ahead, self.distance * y, self.turn * turn + self.curvature * x], axis=-1)
        )

    def wheel_multipliers(self) -> WheelMultipliers:
        """Return the same as factors on the wheel radii and the track; the track must be known."""
        separation = self.distance / self.turn
        half_difference = self.curvature * separation * self.track / 2
        return WheelMultipliers(
            self.distance - half_difference, self.distance + half_difference, separation
        )


def relative(start: Array, end: Array) -> Array:
    """Return the end poses (n, 3) seen from the start poses (n, 3) [m, m, rad]."""
    offset = end - start
    c, s = np.cos(start[..., 2]), np.sin(start[..., 2])
    x, y = offset[..., 0], offset[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, wrap_angle(offset[..., 2])], axis=-1)


def twists_of(motions: Array) -> Array:
    """Return the constant twists (n, 3) [m, m, rad] that make motions (n, 3) in a unit of time.

    This is the logarithm of SE(2): with a constant twist a robot moves along an arc.
    """
    half = motions[..., 2] / 2
    near_zero = np.abs(half) < STRAIGHT
    safe = np.where(near_zero, 1.0, half)
    along = np.where(near_zero, 1 - half * half / 3, safe / np.tan(safe))
    x, y = motions[..., 0], motions[..., 1]
    return np.stack([along * x + half * y, along * y - half * x, motions[..., 2]], axis=-1)


def motions_of(twists: Array) -> Array:
    """Return the motions (n, 3) [m, m, rad] of twists (n, 3) in a unit of time (exp of SE(2))."""
    turn = twists[..., 2]
    near_zero = np.abs(turn) < STRAIGHT
    safe = np.where(near_zero, 1.0, turn)
    along = np.where(near_zero, 1 - turn * turn / 6, np.sin(safe) / safe)
    aside = np.where(near_zero, turn / 2, (1 - np.cos(safe)) / safe)
    x, y = twists[..., 0], twists[..., 1]
    return np.stack([along * x - aside * y, aside * x + along * y, turn], axis=-1)


def chained(steps: Array) -> Array:
    """Chain steps (n, 3) to poses (n + 1, 3) from the origin on; headings are not wrapped."""
    headings = np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(headings[:-1]), np.sin(headings[:-1])
    poses = np.zeros((len(steps) + 1, 3))
    poses[1:, 0] = np.cumsum(c * steps[:, 0] - s * steps[:, 1])
    poses[1:, 1] = np.cumsum(s * steps[:, 0] + c * steps[:, 1])
    poses[:, 2] = headings
    return poses


def seen_from(poses: Array) -> Array:
    """Return matrices (n, 3, 3) that convert twists seen from the origin to those seen from poses.

    They are the adjoints of the inverse poses (n, 3): the same movement of a rigid body in another
    frame.
    """
    x, y, theta = poses[..., 0], poses[..., 1], poses[..., 2]
    c, s = np.cos(theta), np.sin(theta)
    matrices = np.zeros((*poses.shape[:-1], 3, 3))
    matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 0, 2] = c, s, s * x - c * y
    matrices[..., 1, 0], matrices[..., 1, 1], matrices[..., 1, 2] = -s, c, s * y + c * x
    matrices[..., 2, 2] = 1.0
    return matrices


@dataclass(frozen=True, eq=False)
class MotionRun:
    """One drive without a gap."""

    name: str
    stamps: Array
    """(n,) [s], rising."""
    odometry: Array
    """(n, 3) [m, m, rad]: the robot in the odom frame."""
    truth: Array
    """(n, 3) [m, m, rad]: the robot in the map."""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.stamps[-1] - self.stamps[0])

    @property
    def steps(self) -> Array:
        """Motions by odometry from stamp to stamp (n - 1, 3), each seen from its start."""
        return relative(self.odometry[:-1], self.odometry[1:])

    def part(self, first: int, last: int) -> MotionRun:
        """Return the poses from the first index up to, but without, the last."""
        cut = slice(first, last)
        return MotionRun(self.name, self.stamps[cut], self.odometry[cut], self.truth[cut])

    def resampled(self, step: float = STEP) -> MotionRun:
        """Return the drive with a pose at each step [s]; a shorter last step is left out."""
        grid = _even_stamps(self.stamps[0], self.stamps[-1], step)
        tracks = (poses_at(grid, self.stamps, poses) for poses in (self.odometry, self.truth))
        return MotionRun(self.name, grid, *tracks)


def paired_runs(
    odometry_stamps: Array,
    odometry: Array,
    truth_stamps: Array,
    truth: Array,
    *,
    step: float = STEP,
    offset: float = 0.0,
) -> list[MotionRun]:
    """Cut a recording into runs with odometry and truth at common stamps of truth's clock.

    Stamps are (n,) [s], poses (n, 3) [m, m, rad]. A run has a pose at each step [s] and ends where
    truth pauses for longer than ``MAX_GAP``. Odometry at its stamp t belongs to t + offset [s] on
    truth's clock.

    Raises:
        FitError: the two do not overlap, or one is not a valid track of poses.
    """
    _check_track("odometry", odometry_stamps, odometry)
    _check_track("truth", truth_stamps, truth)
    acting = odometry_stamps + offset
    first, last = max(acting[0], truth_stamps[0]), min(acting[-1], truth_stamps[-1])
    if last - first < step:
        raise FitError(
            f"odometry from {acting[0]:.3f} to {acting[-1]:.3f} s and truth from "
            f"{truth_stamps[0]:.3f} to {truth_stamps[-1]:.3f} s do not overlap"
        )
    grid = _even_stamps(first, last, step)
    tracks = poses_at(grid, acting, odometry), poses_at(grid, truth_stamps, truth)
    whole = MotionRun("recording", grid, *tracks)
    gaps = np.flatnonzero(np.diff(truth_stamps) > MAX_GAP)
    ends = np.searchsorted(grid, truth_stamps[gaps], side="right").tolist()
    starts = np.searchsorted(grid, truth_stamps[gaps + 1], side="left").tolist()
    pieces = zip([0, *starts], [*ends, len(grid)], strict=True)
    return [whole.part(start, end) for start, end in pieces if end - start >= 2]


def cut_at(runs: Iterable[MotionRun], stamp: float) -> tuple[list[MotionRun], list[MotionRun]]:
    """Cut drives at a stamp [s] into earlier and later ones; the pose at the cut is in both."""
    earlier, later = [], []
    for run in runs:
        index = int(np.searchsorted(run.stamps, stamp))
        if index >= 1:
            earlier.append(run.part(0, index + 1))
        if index < len(run.stamps) - 1:
            later.append(run.part(index, len(run.stamps)))
    return earlier, later


def poses_at(stamps: Array, known_stamps: Array, poses: Array) -> Array:
    """Interpolate poses (n, 3) at stamps (n,), along the arcs between known poses.

    Straight lines are wrong: where stamps pause while the robot turns, it would seem to drive
    sideways, which the motion model takes for two large turns in each step.
    """
    earlier = np.clip(np.searchsorted(known_stamps, stamps, side="right") - 1, 0, len(poses) - 2)
    spans = known_stamps[earlier + 1] - known_stamps[earlier]
    part = np.clip((stamps - known_stamps[earlier]) / spans, 0.0, 1.0)
    twists = twists_of(relative(poses[earlier], poses[earlier + 1]))
    return compose(poses[earlier], motions_of(part[:, None] * twists))


def _even_stamps(first: float, last: float, step: float) -> Array:
    """Return stamps [s] from the first on, one step apart, none after the last."""
    return first + step * np.arange(int((last - first) / step + 1e-9) + 1, dtype=np.float64)


def _check_track(name: str, stamps: Array, poses: Array) -> None:
    if poses.shape != (len(stamps), 3) or len(stamps) < 2:
        raise FitError(
            f"{name}: {stamps.shape} stamps and {poses.shape} poses; two or more are needed, "
            "each x, y, theta"
        )
    if not (np.isfinite(stamps).all() and np.isfinite(poses).all()):
        raise FitError(f"{name}: a stamp or a pose is not finite")
    if not (np.diff(stamps) > 0).all():
        index = int(np.argmax(np.diff(stamps) <= 0)) + 1
        raise FitError(f"{name}: stamp {index} ({stamps[index]:.6f} s) does not rise")
