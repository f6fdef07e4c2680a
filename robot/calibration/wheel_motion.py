"""How the robot moved between pictures, by the turns of its wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.calibration.drive_log import DriveLog
from robot.description.spec import RobotSpec
from robot.description.unknowns import DELAY, LEFT, RIGHT, SEPARATION
from robot.geometry import Array

STEP_S = 0.025
"""Longest time within which the wheels' speeds count as constant [s]."""

BY_LEFT, BY_RIGHT, BY_SEPARATION, BY_DELAY = range(4)
BY_SLIP = slice(4, 6)
"""Columns of the derivatives."""

KERNEL = np.array([1, 4, 6, 4, 1]) / 16
"""Smooths the encoders' steps. Between two raw samples, interpolation averages the steps, and at a
sample it does not: so a delay would fit best that puts the pictures between the samples, 4 ms off.
After smoothing, both are nearly alike."""

SMALL = 1e-6
"""Change of a relative dimension for a derivative by differences."""
TWIST_S = 0.04
"""Time over which the robot's velocity is measured [s]."""
DELAY_S = 0.3
"""Time over which the change of velocity is measured that tells the delay [s]. Over a shorter time
it is of the encoders' noise, which would seem to tell the delay to a millisecond at any speed."""
MOST_PARTS = 100
"""Most parts of the time between two pictures: for a camera that stalled for seconds."""


@dataclass(frozen=True, eq=False)
class WheelMotion:
    """The wheels of one drive."""

    stamps: Array = field(repr=False)
    """(k,) stamps of the pictures [s]."""
    wheel_stamps: Array = field(repr=False)
    wheel_angles: Array = field(repr=False)
    """(t, 2) left, right [rad]."""
    radii: tuple[float, float]
    """Left and right, as described [m]."""
    separation: float
    """As described [m]."""
    bridged: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp), repr=False)
    """(b,) pictures after which others were left out: no step is known from there."""

    @classmethod
    def of(
        cls, log: DriveLog, spec: RobotSpec, bridged: NDArray[np.intp] | Sequence[int] = ()
    ) -> WheelMotion:
        """Return the motion of a drive, with the wheels' dimensions of a description."""
        left, right = (spec.joints[place].radius for place in spec.axle)
        angles = _smooth(log.wheel_angles)
        return cls(
            log.stamps,
            log.wheel_stamps,
            angles,
            (left, right),
            spec.track,
            np.array(bridged, np.intp),
        )

    def steps(self, values: Array, slip: Array) -> tuple[Array, Array]:
        """Return how the robot moved from each picture to the next, and the derivatives.

        Slip shortens each wheel's way by a share of the mean way (root of the mean square) of both
        wheels as described, and the turn by the difference over the separation as described. So its
        size does not depend on the unknowns: if it did, a smaller robot, or one with larger wheels,
        would explain the same slip better.

        Args:
            values: (15,) differences from the description.
            slip: (k - 1, 2) share of the mean way that each wheel slips.

        Returns:
            (k - 1, 3) poses of the next picture in the frame of the last one [m, m, rad]; (k - 1,
            3, 6) their derivatives by the left and right wheel's relative radius, the relative
            separation, the delay, and the slip of both wheels.
        """
        left, right, separation = values[[LEFT, RIGHT, SEPARATION]]
        track = self.separation * (1 + separation)
        turns = self._turns(values[DELAY])
        way, turn = self._rolled(turns, values, slip)
        moved = _arcs(way, turn)
        # Without slip, as the robot moved: at what the wheels turned, derivatives would be
        # correlated with slip, and a separation would fit best that explains it.
        way_left, way_right = way - turn * track / 2, way + turn * track / 2
        changes = [
            (way_left / (2 * (1 + left)), -way_left / (track * (1 + left))),
            (way_right / (2 * (1 + right)), way_right / (track * (1 + right))),
            (0.0, -turn / (1 + separation)),
        ]
        # By slip as well: wheels that slip seem to roll farther, and the slip's square would be
        # taken for radii that are larger by most of a per cent.
        both = np.hypot(way_left / (1 + left), way_right / (1 + right)) / math.sqrt(2)
        lost_left, lost_right = np.sign(turns).transpose(2, 0, 1) * both
        larger = 1 + (left + right) / 2
        by_slip = [
            (-larger * lost_left / 2, lost_left / self.separation),
            (-larger * lost_right / 2, -lost_right / self.separation),
        ]
        derivatives = np.zeros((*moved.shape, 6))
        columns = (BY_LEFT, BY_RIGHT, BY_SEPARATION, *range(BY_SLIP.start, BY_SLIP.stop))
        for column, (by_way, by_turn) in zip(columns, changes + by_slip, strict=True):
            changed = _arcs(way + SMALL * by_way, turn + SMALL * by_turn)
            derivatives[:, :, column] = (changed - moved) / SMALL
        late, soon = (
            _arcs(*self._rolled(self._turns(values[DELAY] + half), values, slip))
            for half in (DELAY_S / 2, -DELAY_S / 2)
        )
        derivatives[:, :, BY_DELAY] = (late - soon) / DELAY_S
        return moved, derivatives

    def by_errors(self, values: Array, steps: Array, errors: Array) -> Array:
        """Return what the derivatives of steps lack, as the encoders measured with errors.

        Derivatives are taken at how the robot moved, not at how the wheels seemed to: else the
        noise of a robot that drives straight would tell the separation.

        Args:
            values: (15,) differences from the description.
            steps: (k - 1, 3) by the wheels [m, m, rad].
            errors: (k - 1, 3) of the steps, true less measured [m, m, rad].

        Returns:
            (k - 1, 3, 6) to be added to those of ``steps``.
        """
        left, right, separation = values[[LEFT, RIGHT, SEPARATION]]
        track = self.separation * (1 + separation)
        way, turn = errors[:, 0], errors[:, 2]
        by_left = (way - turn * track / 2) / (1 + left)
        by_right = (way + turn * track / 2) / (1 + right)
        result = np.zeros((len(errors), 3, 6))
        result[:, 0, BY_LEFT], result[:, 2, BY_LEFT] = by_left / 2, -by_left / track
        result[:, 0, BY_RIGHT], result[:, 2, BY_RIGHT] = by_right / 2, by_right / track
        result[:, 2, BY_SEPARATION] = -turn / (1 + separation)
        around = steps[:, 2] * track / 2
        rolled = (steps[:, 0] - around) / (1 + left), (steps[:, 0] + around) / (1 + right)
        both = np.maximum(np.hypot(*rolled) / math.sqrt(2), SMALL)
        more = (rolled[0] * by_left + rolled[1] * by_right) / (2 * both)
        for wheel, side in enumerate((1, -1)):
            lost = np.sign(rolled[wheel]) * more
            result[:, 0, BY_SLIP.start + wheel] = -(1 + (left + right) / 2) * lost / 2
            result[:, 2, BY_SLIP.start + wheel] = side * lost / self.separation
        return result

    def twists(self, values: Array, slip: Array | None = None) -> Array:
        """Return the robot's velocity (k, 2) at each picture [m/s, rad/s].

        Args:
            values: (15,) differences from the description.
            slip: (k, 2) of each wheel, from each picture until the next, as far as it is known.
        """
        if slip is None:
            slip = np.zeros((len(self.stamps), 2))
        around = (slip + np.concatenate([slip[:1], slip[:-1]])) / 2
        middle = self.stamps - values[DELAY]
        soon, late = (self._angles(middle + half) for half in (-TWIST_S / 2, TWIST_S / 2))
        way, turn = self._rolled((late - soon)[:, None], values, around)
        return np.column_stack([way, turn]) / TWIST_S

    def _angles(self, stamps: Array) -> Array:
        return np.stack(
            [np.interp(stamps, self.wheel_stamps, angle) for angle in self.wheel_angles.T], axis=-1
        )

    def _turns(self, delay: float) -> Array:
        """Return how far the wheels turned (k - 1, n, 2) [rad] in n parts of each interval."""
        times = self.stamps - delay
        spans = np.diff(times)
        spans[self.bridged] = 0.0
        longest = float(spans.max(initial=0.0))
        parts = min(max(1, math.ceil(longest / STEP_S)), MOST_PARTS)
        within = np.linspace(0.0, 1.0, parts + 1)
        cuts = times[:-1, None] + spans[:, None] * within
        return np.diff(self._angles(cuts), axis=1)

    def _rolled(self, turns: Array, values: Array, slip: Array) -> tuple[Array, Array]:
        """Return way [m] and turn [rad] of the robot (k, n) as wheels turn (k, n, 2) and slip."""
        left, right, separation = values[[LEFT, RIGHT, SEPARATION]]
        rolled_left, rolled_right = (turns * np.array(self.radii)).transpose(2, 0, 1)
        both = np.sqrt((rolled_left**2 + rolled_right**2) / 2)
        lost_left = np.sign(rolled_left) * both * slip[:, :1]
        lost_right = np.sign(rolled_right) * both * slip[:, 1:]
        lost = (lost_left + lost_right) / 2 * (1 + (left + right) / 2)
        rolled_left, rolled_right = rolled_left * (1 + left), rolled_right * (1 + right)
        way = (rolled_left + rolled_right) / 2 - lost
        turn = (rolled_right - rolled_left) / (self.separation * (1 + separation))
        turn -= (lost_right - lost_left) / self.separation
        return way, turn


def _arcs(way: Array, turn: Array) -> Array:
    """Return where arcs (k, n) one after the other lead (k, 3), by their ways and turns."""
    heading = np.cumsum(turn, axis=1) - turn / 2
    chord = way * np.sinc(turn / (2 * np.pi))
    return np.column_stack(
        [
            (chord * np.cos(heading)).sum(axis=1),
            (chord * np.sin(heading)).sum(axis=1),
            turn.sum(axis=1),
        ]
    )


def _smooth(angles: Array) -> Array:
    reach = len(KERNEL) // 2
    padded = np.pad(angles, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(wheel, KERNEL, mode="valid") for wheel in padded.T], axis=-1)
