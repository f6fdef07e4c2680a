"""Trajectories: the poses of a body at many stamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import InitVar, dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robot.errors import BrickPoseError
from robot.geometry import Array, heading_angles, heading_vectors

FARTHEST = 1e9
"""A coordinate beyond this [m] is not a position."""
LATEST = 1e11
"""A stamp beyond this [s] is not in seconds: the year 5000 comes before it."""
FLAT = 1e-9
"""A trajectory is planar if it rises and tilts by no more than this [m, -]."""
NO_LENGTH = 1e-6
"""A quaternion shorter than this has no direction."""

LEFT_OUT = "left out:"
"""Start of the note that counts poses that cannot be used."""
MOST_LEFT_OUT = 0.1
"""A file with a larger part of such poses is no trajectory."""

Indices = NDArray[np.int64] | NDArray[np.bool_]


class TrajectoryError(BrickPoseError, ValueError):
    """A trajectory that cannot be used; the message names the file and the line."""

    exit_code = 2


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses of a body in a world frame (z up), at rising stamps; the arrays are read-only.

    Raises:
        TrajectoryError: fewer than two poses, a stamp that is not after the one before it (with
            ``repeats``: before it), a number that is not finite or far too large, a quaternion
            without length.
    """

    stamps: Array
    """(n,) [s], strictly rising; with ``repeats`` never falling."""
    positions: Array
    """(n, 3) [m]."""
    quaternions: Array
    """(n, 4) x y z w, world from body; normalized to unit length."""
    source: str = ""
    """Its name in messages, such as the file's name."""
    notes: tuple[str, ...] = ()
    """Comments of the file."""
    repeats: bool = False
    """Whether several poses may have the same stamp, as in freiburg2_desk of the TUM benchmark."""
    lines: InitVar[Sequence[int] | None] = None
    """The line (n,) of each pose in the file, for messages."""

    def __post_init__(self, lines: Sequence[int] | None) -> None:
        stamps = _numbers(self.stamps, (-1,))
        positions = _numbers(self.positions, (len(stamps), 3))
        quaternions = _numbers(self.quaternions, (len(stamps), 4))
        if len(stamps) < 2:
            raise TrajectoryError(f"{self.name} has {_poses(len(stamps))}; valid are 2 and more")
        fault = _first_fault(stamps, positions, quaternions, self.repeats)
        if fault is not None:
            index, message = fault
            where = f"pose {index + 1}" if lines is None else f"line {lines[index]}"
            raise TrajectoryError(f"{self.name}, {where}: {message}")
        quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
        for field, values in (
            ("stamps", stamps),
            ("positions", positions),
            ("quaternions", quaternions),
        ):
            values.setflags(write=False)
            object.__setattr__(self, field, values)

    @classmethod
    def of_poses(
        cls,
        stamps: ArrayLike,
        poses: ArrayLike,
        source: str = "",
        notes: tuple[str, ...] = (),
        lines: Sequence[int] | None = None,
        repeats: bool = False,
    ) -> Trajectory:
        """Make a trajectory of stamps (n,) [s] and planar poses (n, 3): x, y [m], theta [rad]."""
        planar = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
        with np.errstate(invalid="ignore"):  # an infinite angle gives NaN, which is refused
            half = heading_vectors(planar[:, 2] / 2)
        nothing = np.zeros(len(planar))
        return cls(
            np.asarray(stamps, dtype=np.float64),
            np.column_stack([planar[:, :2], nothing]),
            np.column_stack([nothing, nothing, half[:, 1], half[:, 0]]),
            source,
            notes,
            repeats,
            lines,
        )

    @classmethod
    def of_rows(
        cls,
        stamps: Array,
        positions: Array,
        quaternions: Array,
        source: str,
        notes: tuple[str, ...],
        lines: Sequence[int],
    ) -> Trajectory:
        """Make a trajectory of a file's rows; a few without a pose are left out, as a note says.

        Such a row has a number that is not finite, or a quaternion without length: many programs
        write nan or zeros where they know nothing.
        """
        known = np.isfinite(np.column_stack([stamps, positions, quaternions])).all(axis=1)
        known &= np.abs(quaternions).max(axis=1, initial=0) >= NO_LENGTH
        lost = int(np.count_nonzero(~known))
        if 0 < lost <= MOST_LEFT_OUT * len(known):
            stamps, positions, quaternions = stamps[known], positions[known], quaternions[known]
            lines = np.asarray(lines)[known].tolist()
            notes = (*notes, f"{LEFT_OUT} {lost} of {len(known)} poses of {source}")
        return cls(stamps, positions, quaternions, source, notes, True, lines)

    def __len__(self) -> int:
        return len(self.stamps)

    @property
    def name(self) -> str:
        """The source, or a general name if there is none."""
        return self.source or "the trajectory"

    @property
    def duration(self) -> float:
        """Time from the first pose to the last [s]."""
        return float(self.stamps[-1] - self.stamps[0])

    @property
    def planar(self) -> bool:
        """Whether it stays at one height and only turns about z."""
        heights = self.positions[:, 2]
        return bool(np.ptp(heights) <= FLAT and (np.abs(self.quaternions[:, :2]) <= FLAT).all())

    @property
    def poses(self) -> Array:
        """The poses from above (n, 3): x, y [m] and the heading [rad] of the body's x axis."""
        x, y, z, w = self.quaternions.T
        ahead = np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z)])
        return np.column_stack([self.positions[:, :2], heading_angles(ahead)])

    def selected(self, indices: Indices) -> Trajectory:
        """Return the poses at rising indices, or where a mask (n,) is true."""
        return Trajectory(
            self.stamps[indices],
            self.positions[indices],
            self.quaternions[indices],
            self.source,
            self.notes,
            self.repeats,
        )

    def to_planar(self) -> Trajectory:
        """Return the planar trajectory seen from above: without height, roll and pitch."""
        return Trajectory.of_poses(
            self.stamps, self.poses, self.source, self.notes, repeats=self.repeats
        )

    def without_repeats(self) -> Trajectory:
        """Keep only the last of several poses with the same stamp."""
        return replace(self.selected(np.append(np.diff(self.stamps) > 0, True)), repeats=False)

    def shifted(self, seconds: float) -> Trajectory:
        """Return the same poses at later stamps, by some time [s]."""
        return replace(self, stamps=self.stamps + seconds, lines=None)


def _numbers(values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return a copy of the values in the given shape."""
    try:
        return np.array(values, dtype=np.float64, order="C").reshape(shape)
    except ValueError as error:
        raise TrajectoryError(f"numbers of another shape than {shape}: {error}") from error


def _poses(count: int) -> str:
    return f"{count} pose{'' if count == 1 else 's'}" if count else "no poses"


def _first_fault(
    stamps: Array, positions: Array, quaternions: Array, repeats: bool
) -> tuple[int, str] | None:
    """Return the index of the first invalid pose, and what is wrong with it."""
    largest = np.abs(quaternions).max(axis=1)
    falls = np.less if repeats else np.less_equal
    faults = (
        (~np.isfinite(np.column_stack([stamps, positions, quaternions])).all(axis=1), _not_finite),
        (np.abs(stamps) > LATEST, _not_seconds),
        ((np.abs(positions) > FARTHEST).any(axis=1) | (largest > FARTHEST), _too_far),
        (np.append(False, falls(stamps[1:], stamps[:-1])), _not_rising),
        (largest < NO_LENGTH, _no_length),
    )
    result = [(int(np.argmax(wrong)), message) for wrong, message in faults if wrong.any()]
    if not result:
        return None
    index, message = min(result, key=lambda item: item[0])
    return index, message(index, stamps)


def _not_finite(index: int, stamps: Array) -> str:
    return "a number is not finite; valid are numbers"


def _not_seconds(index: int, stamps: Array) -> str:
    return f"stamp {stamps[index]:.9g} is beyond {LATEST:g}; stamps are seconds"


def _too_far(index: int, stamps: Array) -> str:
    return f"a number is beyond {FARTHEST:g}; positions are metres"


def _not_rising(index: int, stamps: Array) -> str:
    before, stamp = stamps[index - 1], stamps[index]
    if stamp == before:
        return f"stamp {_short(stamp)} is repeated; each must be after the one before it"
    return f"stamp {_short(stamp)} follows {_short(before)}; stamps must rise"


def _no_length(index: int, stamps: Array) -> str:
    return "its quaternion has no length; valid is one of length 1"


def _short(stamp: float) -> str:
    return np.format_float_positional(stamp, precision=9, trim="-")
