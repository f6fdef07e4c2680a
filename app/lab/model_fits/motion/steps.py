"""How much the motion model lets each step of a drive err, added up along the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.lab.model_fits.motion.twists import chained, relative, seen_from
from robot.geometry import Array, wrap_angle
from robot.localization.models.differential_motion import STANDING_M

Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class ErringPath:
    """Where odometry went, and what its steps' errors amount to, by alpha.

    A step's covariance is linear in alpha1 to alpha4 (Probabilistic Robotics, Table 5.6, with
    alphas as variances). Told as twists seen from the path's start, where small errors of steps
    simply add up, so do their covariances; a window's is the difference of two sums.
    """

    poses: Array
    """(n + 1, 3) [m, m, rad], headings not wrapped, from the origin on."""
    sums: Array
    """(n + 1, 4, 3, 3): covariance of all steps before a pose, for each alpha at one."""

    @classmethod
    def along(cls, steps: Array) -> ErringPath:
        """The path of steps (n, 3) [m, m, rad], each seen from its start."""
        poses = chained(steps)
        sums = np.zeros((len(poses), 4, 3, 3))
        np.cumsum(_by_alpha(poses, steps), axis=0, out=sums[1:])
        return cls(poses, sums)

    def moved(self, start: Places, end: Places) -> Array:
        """Motions (k, 3) from places (k,) of the path to others (k,)."""
        return relative(self.poses[start], self.poses[end])

    def covariances(self, start: Places, end: Places) -> Array:
        """(k, 4, 3, 3) of the motions between places (k,), seen from their ends, by alpha."""
        to_end = seen_from(self.poses[end])[:, None]
        whole: Array = to_end @ (self.sums[end] - self.sums[start]) @ np.swapaxes(to_end, -1, -2)
        return whole


def _by_alpha(poses: Array, steps: Array) -> Array:
    """Covariances (n, 4, 3, 3) of steps by alpha, as twists seen from the path's start."""
    turn, distance, last = _legs(steps)
    toward = poses[:-1, 2] + turn
    first_turn, last_turn = _outer(_turning_at(poses[:-1])), _outer(_turning_at(poses[1:]))
    going = _outer(np.stack([np.cos(toward), np.sin(toward), np.zeros_like(toward)], axis=-1))
    square1, square2 = (np.square(_either_way(angle))[:, None, None] for angle in (turn, last))
    gone = np.square(distance)[:, None, None]
    return np.stack(
        [
            square1 * first_turn + square2 * last_turn,
            gone * (first_turn + last_turn),
            gone * going,
            (square1 + square2) * going,
        ],
        axis=1,
    )


def _legs(steps: Array) -> tuple[Array, Array, Array]:
    """First turn, distance and last turn (n,) of each step, as the motion model has them."""
    distance = np.hypot(steps[:, 0], steps[:, 1])
    turn = np.where(distance <= STANDING_M, 0.0, np.arctan2(steps[:, 1], steps[:, 0]))
    return turn, distance, wrap_angle(steps[:, 2] - turn)


def _either_way(turn: Array) -> Array:
    """The smaller turn (n,), forward or in reverse."""
    return np.minimum(np.abs(turn), np.abs(wrap_angle(turn + np.pi)))


def _turning_at(poses: Array) -> Array:
    """Twists (n, 3) of a turn by one about where the poses are."""
    return np.stack([poses[:, 1], -poses[:, 0], np.ones(len(poses))], axis=-1)


def _outer(vectors: Array) -> Array:
    return vectors[:, :, None] * vectors[:, None, :]
