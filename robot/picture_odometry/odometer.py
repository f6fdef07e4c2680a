"""Motion between two pictures: how the floor before the robot moved, without asking a wheel."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.geometry import Array, Pose2
from robot.interface import Frame
from robot.picture_odometry.alignment import (
    AA,
    AB,
    BB,
    COUNT,
    MARGIN,
    RESIDUAL,
    SQUARES,
    WEIGHT,
    Patch,
    accumulate,
    similarity,
    slopes,
    step_sums,
)
from robot.picture_odometry.ground import GroundView
from robot.picture_odometry.settings import PictureOdometrySettings

SMOOTHED_PX = 0.9
"""Standard deviation of the blur before patches are compared [px]."""
LARGE_PX = 17
"""What is larger than this is no grain: light and its loss towards the corners, which stand still
in the picture, would say that the robot stands [px]."""
STRIDE = 2
"""Every how many pixels are compared: the blur makes neighbours alike, so that more tell little."""
ROUNDS = ((4, 6, 0.1), (STRIDE, 2, 0.02))
"""Of the rounds of steps: every how many pixels are used, most steps, and the length of a step that
is the last one [px]."""
LONGEST_PX = 2.0
"""Longest step [px]."""
NOISE_SHARE = 1.8
"""By how much the covariance of a sum over pixels is larger than if their noise was independent:
the blur and the interpolation spread the noise of one over its neighbours."""
LEAST_ALIKE = 0.75
"""Patches that correlate less are not the same floor, or have nothing but noise."""
LESS_ALIKE = 0.04
"""If they correlate by so much less than before, it is tried whether the floor is nearer now."""
RAISED = (-0.08, -0.04, -0.02, 0.02, 0.04, 0.08)
"""Shares by which the floor may look larger or smaller in the next picture: a hand lifts the robot
by 2 to 12 mm meanwhile, of the camera's 160."""
FEWEST = 0.3
"""Share of the patch's pixels that both pictures have to show."""
UNKNOWN = 1.0
"""Standard deviation of a motion along a direction in which nothing is seen [m]; turns by arm."""
ARM_M = 0.05
"""A turn counts by the way of a point so far from the patch's middle [m]."""
FADED = 0.7
"""Of a direction whose slopes agree by less than this share between both pictures, nothing is seen:
they are noise, or what pixels make of a straight edge."""
CLEAR = 2.0
"""What is seen has to vary by so many times what the picture's own noise would. Noise that is alike
in two pictures is no floor."""
NOISE_LEFT = 0.03
"""Share of the variance of the picture's noise that is left in a patch."""

GRAIN = 0.22
"""Where fewer of the pixels than this share tell as much as all do, only edges of tape are seen. On
bare floors it is 0.1 to 0.2 (*town*, *square* and *stub*, seed 15201), on textures 0.25 to 0.9."""
EDGE_SD_M = (5e-4, 5e-4, 2.5e-4)
"""Errors that all pixels of an edge have alike: of a motion ahead, aside, and of a turn by arm [m].
On bare floors as above, the errors of a picture's motion are 0.1 to 0.2 mm ahead, 0.2 to 0.3 mm
aside and 1 mrad in the middle, 0.7 mm, 2 mm and 8 mrad in one of a hundred pictures."""

_PLACES = np.array([[3, 4, 6], [4, 5, 7], [6, 7, 8]])
"""Where ``step_sums`` has the information (3, 3)."""
_LITTLE = np.diag([1e-3, 1e-3, 1.0])
"""Lets a step be solved for that no pixel tells of."""


@dataclass(frozen=True, slots=True, eq=False)
class PictureMotion:
    """How the robot moved between two pictures."""

    begin: float
    """When the compared floor was exposed in the first picture, on the robot's clock [s]. With a
    rolling shutter that is not the picture's stamp: the patch is not in its middle."""
    end: float
    """The same, of the second picture [s]."""
    motion: Pose2
    """The robot's new pose in its old frame; where nothing is seen, as it was predicted."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]; along what is not seen, its standard deviation is ``UNKNOWN``."""
    seen: int
    """In how many directions of three the motion is seen: 3 all, 2 that of an edge not, 0 none."""
    alike: float
    """Correlation of both patches, -1 to 1."""
    predicted: Pose2
    """What was predicted, as by the wheels."""
    larger: float
    """By which share the floor looks larger than before: it is nearer."""
    larger_sd: float
    """Standard deviation of that share; inf if nothing is seen."""
    textured: bool
    """Whether each picture has something to compare, even if both do not fit."""


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """A motion of the patch, and what the sums say of it."""

    motion: Array
    alike: float
    covariance: Array
    """(4, 4), before the share that is not seen is told."""
    seen: NDArray[np.bool_]
    axes: Array
    squared: Array
    variance: float
    grain: bool
    """Whether more is seen than a few edges."""


class PictureOdometer:
    """Compares each picture with the one before; one thread calls it."""

    def __init__(self, view: FloorView, settings: PictureOdometrySettings) -> None:
        """Prepare to look at the floor through one camera.

        Raises:
            GroundError: the camera does not see the floor that the settings name.
        """
        self.view = view
        self.ground = GroundView.of(view, settings)
        self._settings = settings
        middle_row = (view.lens.height - 1) / 2
        self._a_row = view.lens.readout / max(1, view.lens.height - 1)
        # The projection of a floor that is lower than it is thought shrinks to the camera's foot.
        foot = view.robot_from_camera[:2, 3]
        self._arm: Array = (self.ground.middle - foot) / self.ground.resolution
        self._late = (float(self.ground.rows.mean()) - middle_row) * self._a_row
        # How many rows of the picture a metre forward is: less than none, as far is above.
        self._rows_per_px = -np.gradient(self.ground.rows)
        self._unit = np.array([1.0, 1.0, self.ground.resolution / ARM_M])
        """What makes a motion's turn a way [px]."""
        self._before: tuple[float, Patch] | None = None
        self._last = np.zeros(4)
        """The last motion of the patch, by second."""
        self._variance = 4.0
        self._usual = LEAST_ALIKE
        """How much patches correlate that fit."""
        self._noise = self._contrast = 0.0
        self._right, self._totals = np.empty(4), np.empty(7)
        self._squared, self._crossed, self._spread = np.empty((3, 4, 4))
        self._sums = np.empty(9)

    def exposed(self, frame: Frame) -> float:
        """Return when the compared floor was exposed in a picture, on the robot's clock [s]."""
        return frame.stamp + self._late

    def forget(self) -> None:
        """Compare the next picture with none: the robot was put elsewhere."""
        self._before = None

    def measure(self, frame: Frame, predicted: Pose2 | None) -> PictureMotion | None:
        """Compare a picture with the one before.

        Args:
            frame: the picture.
            predicted: the robot's motion since then, from ``exposed`` to ``exposed``, as the wheels
                tell it; None to begin anew with this picture.

        Returns:
            None of a first picture.
        """
        stamp, patch = self.exposed(frame), self._patch(frame.image)
        before, self._before = self._before, (stamp, patch)
        if before is None or predicted is None or not stamp > before[0]:
            return None
        return self._compare(before, (stamp, patch), predicted)

    def _patch(self, image: NDArray[np.uint8]) -> Patch:
        floor = self.ground.project(image).astype(np.float32)
        self._noise = self.ground.noise(image)
        fine = np.asarray(cv2.GaussianBlur(floor, (0, 0), SMOOTHED_PX), dtype=np.float32)
        coarse = np.asarray(cv2.blur(floor, (LARGE_PX, LARGE_PX)), dtype=np.float32)
        patch = np.empty((*self.ground.shape, 3), dtype=np.float32)
        slopes(fine, coarse, patch)
        return patch

    def __getstate__(self) -> dict[str, object]:
        """Leave the last picture out: after a jump, a replay has another one."""
        return self.__dict__ | {"_before": None}

    def _compare(
        self, before: tuple[float, Patch], after: tuple[float, Patch], predicted: Pose2
    ) -> PictureMotion:
        seconds = after[0] - before[0]
        skew = self._rows_per_px * self._a_row / seconds
        guess = self._of_patch(predicted)
        patches = before[1], after[1]
        fit = self._fit(patches, self._nearest(patches, skew, guess, seconds), guess, skew)
        if not self._textured:
            return self._result(fit, before[0], after[0], predicted)  # no search finds more
        if fit.alike < LEAST_ALIKE:
            other = self._fit(patches, self._searched(patches), guess, skew)
            fit = other if other.alike > fit.alike else fit
        if fit.alike < self._usual - LESS_ALIKE:
            nearer = self._raised(patches, guess, skew)
            fit = nearer if nearer.alike > fit.alike + LESS_ALIKE / 2 else fit
        elif fit.seen.any():
            self._usual += 0.3 * (fit.alike - self._usual)
        return self._result(fit, before[0], after[0], predicted)

    def _nearest(
        self, patches: tuple[Patch, Patch], skew: Array, guess: Array, seconds: float
    ) -> Array:
        """Return where to begin: what was predicted, that nothing moves, or the last motion."""
        begins = guess, np.zeros(4), self._last * seconds
        alike = [self._alike(patches, begin, skew) for begin in begins]
        return begins[int(np.argmax(alike))]

    def _raised(self, patches: tuple[Patch, Patch], guess: Array, skew: Array) -> _Fit:
        """Return the best fit of a floor that is nearer or farther: the robot is in the air."""
        begins = [guess + np.array([*(-share * self._arm), 0.0, share]) for share in RAISED]
        alike = [self._alike(patches, begin, skew) for begin in begins]
        motion = begins[int(np.argmax(alike))].copy()
        for _ in range(ROUNDS[0][1]):
            self._sum(patches, motion, skew)
            step = np.linalg.lstsq(self._squared, self._right, rcond=1e-9)[0]
            motion += step * min(1.0, LONGEST_PX / max(math.hypot(step[0], step[1]), 1e-9))
        self._sum(patches, motion, skew)
        return self._judged(motion, guess)

    def _sum(self, patches: tuple[Patch, Patch], motion: Array, skew: Array) -> None:
        accumulate(
            *patches, motion, skew, self._variance, STRIDE,
            self._right, self._squared, self._crossed, self._spread, self._totals,
        )  # fmt: skip

    def _searched(self, patches: tuple[Patch, Patch]) -> Array:
        """Return the shift by which two patches correlate most, wherever it is."""
        before, after = (np.ascontiguousarray(patch[..., 0]) for patch in patches)
        (right, down), _ = cv2.phaseCorrelate(before, after)
        return np.array([down, right, 0.0, 0.0])

    def _fit(self, patches: tuple[Patch, Patch], begin: Array, guess: Array, skew: Array) -> _Fit:
        motion = self._climbed(patches, begin, skew, held=False)
        if self._alike(patches, motion, skew) < self._alike(patches, begin, skew):
            # Along an edge, steps follow noise, and away from what is seen beside it.
            motion = self._climbed(patches, begin, skew, held=True)
        self._sum(patches, motion, skew)
        return self._judged(motion, guess)

    def _climbed(
        self, patches: tuple[Patch, Patch], begin: Array, skew: Array, *, held: bool
    ) -> Array:
        """Return where steps lead; ``held`` along the edge that is seen most, they make none."""
        motion = begin.copy()
        for stride, most, enough in ROUNDS:
            for _ in range(most):
                step_sums(*patches, motion, skew, self._variance, stride, self._sums)
                step = _step(self._sums[_PLACES], self._sums[:3], held=held)
                # Steps longer than a grain lead to another grain.
                length = math.hypot(step[0], step[1])
                motion[:3] += step if length < LONGEST_PX else step * (LONGEST_PX / length)
                if length < enough:
                    break
        return motion

    def _alike(self, patches: tuple[Patch, Patch], motion: Array, skew: Array) -> float:
        return similarity(*patches, motion, skew, self._variance, 3)

    def _judged(self, motion: Array, guess: Array) -> _Fit:
        """Keep of a motion what is seen of it."""
        totals, (height, width) = self._totals, self.ground.shape
        self._contrast = float(min(totals[AA], totals[BB]) / max(totals[WEIGHT], 1e-12))
        alike = float(totals[AB] / math.sqrt(max(totals[AA] * totals[BB], 1e-12)))
        clear = totals[AB] > CLEAR * NOISE_LEFT * self._noise**2 * totals[WEIGHT]
        enough = clear and totals[COUNT] * STRIDE**2 >= FEWEST * (height - 2 * MARGIN) * (
            width - 2 * MARGIN
        )
        variance = float(totals[RESIDUAL] / max(totals[WEIGHT], 1e-12))
        unit = self._unit
        crossed = self._crossed[:3, :3] * np.outer(unit, unit)
        squared = self._squared[:3, :3] * np.outer(unit, unit)
        spread = NOISE_SHARE * self._spread[:3, :3] * np.outer(unit, unit)
        values, axes = np.linalg.eigh(crossed)
        noisy = np.einsum("ka,kl,la->a", axes, squared, axes)
        noise = np.einsum("ka,kl,la->a", axes, spread, axes)
        limit = self._settings.largest_sd / self.ground.resolution
        with np.errstate(divide="ignore", invalid="ignore"):
            sd = np.sqrt(noise) / values
        seen = enough & (values > FADED * noisy) & (sd < limit)
        known = axes[:, seen]
        solved = known / values[seen]
        # Along what is not seen, what was predicted stands.
        apart = (motion - guess)[:3] / unit
        best = guess.copy()
        best[:3] += unit * (known @ (known.T @ apart))
        best[3] = motion[3]
        covariance = solved @ (known.T @ spread @ known) @ solved.T
        information = self._squared[0, 0] + self._squared[1, 1]
        grain = information**2 > GRAIN * totals[COUNT] * totals[SQUARES]
        return _Fit(best, alike, covariance, seen, axes, self._squared.copy(), variance, grain)

    def _result(self, fit: _Fit, begin: float, end: float, predicted: Pose2) -> PictureMotion:
        size = self.ground.resolution
        seen = int(fit.seen.sum()) if fit.alike >= LEAST_ALIKE else 0
        if seen:
            self._variance = 0.7 * self._variance + 0.3 * min(max(fit.variance, 0.5), 200.0)
            self._last = np.array([*fit.motion[:3], 0.0]) / (end - begin)
        motion = self._of_robot(fit.motion) if seen else predicted
        hidden = fit.axes[:, ~fit.seen] if seen else np.eye(3)
        covariance = size**2 * fit.covariance if seen else np.zeros((3, 3))
        covariance = covariance + UNKNOWN**2 * hidden @ hidden.T
        if not fit.grain:
            covariance = covariance + np.diag(np.square(EDGE_SD_M))
        unit = np.diag([1.0, 1.0, 1 / ARM_M])
        at_robot = self._lever(motion) @ unit
        covariance = at_robot @ covariance @ at_robot.T
        moved = self._settings.scale_error * np.array([motion.x, motion.y, motion.theta])
        covariance = covariance + np.diag(np.square(moved)) + np.diag([1e-10, 1e-10, 1e-9])
        larger, larger_sd = self._growth(fit)
        return PictureMotion(
            begin, end, motion, covariance, seen, fit.alike, predicted,
            larger, larger_sd, self._textured,
        )  # fmt: skip

    @property
    def _textured(self) -> bool:
        """Whether each of the last two patches has something to compare."""
        return self._contrast > CLEAR * NOISE_LEFT * self._noise**2

    def _growth(self, fit: _Fit) -> tuple[float, float]:
        """Return by which share the floor looks larger than before, and its sd."""
        information = float(self._crossed[3, 3])
        if not fit.seen.all() or information <= FADED * float(self._squared[3, 3]):
            return 0.0, math.inf
        step = np.linalg.lstsq(self._crossed, self._right, rcond=1e-9)[0]
        inverse = np.linalg.pinv(self._crossed)
        spread = NOISE_SHARE * inverse @ self._spread @ inverse.T
        return float(fit.motion[3] + step[3]), float(math.sqrt(max(spread[3, 3], 0.0)))

    def _of_patch(self, motion: Pose2) -> Array:
        """Return the motion (4,) of the patch, as ``accumulate`` has it, of a robot's motion."""
        middle = self.ground.middle
        shift = middle - motion.inverse().apply(middle[None])[0]
        return np.array([*shift / self.ground.resolution, motion.theta, 0.0])

    def _of_robot(self, motion: Array) -> Pose2:
        """Return the robot's motion of one of the patch; the opposite of ``_of_patch``."""
        middle = self.ground.middle
        shift = motion[:2] + motion[3] * self._arm
        seen_from = middle - self.ground.resolution * shift
        x, y = middle - Pose2(0.0, 0.0, float(motion[2])).apply(seen_from[None])[0]
        return Pose2(float(x), float(y), float(motion[2]))

    def _lever(self, motion: Pose2) -> Array:
        """Return what the robot's motion changes by the patch's (3, 3) [m, m, rad]."""
        x, y = self.ground.middle
        c, s = math.cos(motion.theta), math.sin(motion.theta)
        return np.array([[c, -s, y], [s, c, -x], [0.0, 0.0, 1.0]])


def _step(information: Array, right: Array, *, held: bool) -> Array:
    """Return the step (3,) of a motion; ``held`` has none along the clearest edge."""
    known: Array = information + _LITTLE
    free: Array = np.eye(3)
    if held:
        free = np.zeros((3, 2))
        free[:2, 0], free[2, 1] = np.linalg.eigh(known[:2, :2])[1][:, 1], 1.0
    step = np.linalg.solve(free.T @ known @ free, free.T @ right)
    return free @ np.asarray(step, dtype=np.float64)
