"""Normal equations of a drive: a chain of pictures, each also tied to the robot's unknowns.

Each picture has five unknowns of its own: the robot's pose, and the slip of both wheels until the
next picture. They are tied to those of the next picture only, so their normal equations are banded.
The robot's unknowns are in all pictures; they are solved for first (Schur complement; Triggs et al.
2000, section 6.1). Its inverse is their covariance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from robot.calibration.misses import Misses
from robot.calibration.tape_edges import TapeEdges
from robot.compiling import compiled
from robot.description.unknowns import COUNT
from robot.geometry import Array, wrap_angle

STATE = 5
"""Unknowns of a picture: x, y, theta, left slip, right slip."""
BAND = 2 * STATE - 1
"""Diagonals beside the main one: neighbouring pictures depend on each other."""
CAUCHY = 3.0
"""Distance from which on an edge counts less, in standard deviations. Half and twice: unknowns are
as well known, and maps within 0.1 mm (``python -m benchmarks.constants``)."""
LEAST_INFORMATION = 1e-12
"""What is known less counts as unknown [1/unit^2]."""
SLIP_SD, SLIP_TIME = 0.04, 1.0
"""Standard deviation of a wheel's slip, and the time over which it forgets what it was [s]. Half of
both: an unknown is off by up to 4.7 standard deviations instead of 2.2, and the path of two
calibrations by 0.8 mm instead of 0.6; twice: by 2.2, and 0.3 mm (``python -m
benchmarks.constants``)."""


class Equations:
    """Normal equations: a chain of pictures, each also tied to the robot's unknowns."""

    def __init__(self, count: int, unknowns: int = COUNT) -> None:
        """Begin without any information.

        Args:
            count: of pictures.
            unknowns: that all pictures share: those of the robot, and of a map that is not known.
        """
        self._unknowns = unknowns
        self._own = np.zeros((count, STATE, STATE))
        self._next = np.zeros((count, STATE, STATE))
        """From each picture (rows) to the next one (columns)."""
        self._shared = np.zeros((count, STATE, unknowns))
        self._robot = np.zeros((unknowns, unknowns))
        self._right = np.zeros((count, STATE))
        self._robot_right = np.zeros(unknowns)
        self.cost = 0.0
        self.lost_cost = 0.0
        """Of that what edges cost that lie near none of the field's."""
        self.misses: Misses
        self.tape: TapeEdges
        """Which the misses are off."""
        self._root: Array

    def add_sightings(self, seen: Misses, doubt: float) -> None:
        """Add the edges that were seen, with Cauchy's weights and a factor of their deviations."""
        self.misses = seen
        squares = (seen.residuals / (CAUCHY * doubt)) ** 2
        self.cost += float(CAUCHY**2 * np.log1p(squares).sum())
        self._root = root = (1 / np.sqrt(1 + squares) / doubt)[:, None]
        _add_rows(
            seen.picture,
            root * seen.by_pose,
            root * seen.by_unknowns,
            seen.map_unknowns,
            root * seen.by_map,
            root[:, 0] * seen.residuals,
            self._own,
            self._shared,
            self._robot,
            self._right,
            self._robot_right,
        )

    def add_pairs(self, error: Array, own: Array, following: Array, robot: Array) -> None:
        """Add what ties pictures to the next ones.

        Args:
            error: (k - 1, m) in standard deviations.
            own: (k - 1, m, 5) its derivatives by a picture's own unknowns.
            following: (k - 1, m, 5) by those of the next picture.
            robot: (k - 1, m, 15) by the robot's unknowns.
        """
        self.cost += float((error**2).sum())
        self._own[:-1] += own.transpose(0, 2, 1) @ own
        self._own[1:] += following.transpose(0, 2, 1) @ following
        self._next[:-1] += own.transpose(0, 2, 1) @ following
        self._shared[:-1, :, :COUNT] += own.transpose(0, 2, 1) @ robot
        self._shared[1:, :, :COUNT] += following.transpose(0, 2, 1) @ robot
        self._right[:-1] -= np.einsum("nij,ni->nj", own, error)
        self._right[1:] -= np.einsum("nij,ni->nj", following, error)
        flat = robot.reshape(-1, COUNT)
        self._robot[:COUNT, :COUNT] += flat.T @ flat
        self._robot_right[:COUNT] -= flat.T @ error.reshape(-1)

    def add_slip(self, slip: Array, stamps: Array) -> None:
        """Add that slip changes slowly, and is small (a first-order process)."""
        kept = np.exp(-np.diff(stamps) / SLIP_TIME)
        sd = SLIP_SD * np.sqrt(1 - kept**2)
        error = (slip[1:] - kept[:, None] * slip[:-1]) / sd[:, None]
        own = np.zeros((len(error), 2, STATE))
        following = np.zeros((len(error), 2, STATE))
        for wheel in range(2):
            own[:, wheel, 3 + wheel] = -kept / sd
            following[:, wheel, 3 + wheel] = 1 / sd
        self.add_pairs(error, own, following, np.zeros((len(error), 2, COUNT)))
        self._own[0, [3, 4], [3, 4]] += 1 / SLIP_SD**2
        self._right[0, 3:] -= slip[0] / SLIP_SD**2
        self.cost += float((slip[0] ** 2).sum()) / SLIP_SD**2

    def add_start(self, pose: Array, given_pose: Array, information: Array) -> None:
        """Add the pose (3,) that was told for the first picture."""
        difference = pose - given_pose
        difference[2] = wrap_angle(float(difference[2]))
        self._own[0, :3, :3] += information
        self._right[0, :3] -= information @ difference
        self.cost += float(difference @ information @ difference)

    def add_prior(self, difference: Array, information: Array) -> None:
        """Add how the shared unknowns (s,) differ from what they are thought to be.

        The information (s, s) says how well that is known.
        """
        self._robot += information
        self._robot_right -= information @ difference
        self.cost += float(difference @ information @ difference)

    def solve(self) -> tuple[Array, Array, Array, Array]:
        """Return the steps (k, 5) and (s,), the latter's covariance, and the last pose's."""
        count = len(self._own)
        size = count * STATE
        factor = self._factor()
        shared = self._shared.reshape(size, self._unknowns)
        both = np.column_stack([shared, self._right.reshape(size)])
        solved = cho_solve_banded((factor, True), both, check_finite=False)
        schur = self._robot - shared.T @ solved[:, :-1]
        covariance = np.asarray(np.linalg.inv((schur + schur.T) / 2), np.float64)
        robot = covariance @ (self._robot_right - shared.T @ solved[:, -1])
        own = solved[:, -1] - solved[:, :-1] @ robot
        last = np.zeros((size, 3))
        last[size - STATE : size - STATE + 3] = np.eye(3)
        own_last = cho_solve_banded((factor, True), last, check_finite=False)[
            size - STATE : size - STATE + 3
        ]
        by_robot = solved[size - STATE : size - STATE + 3, :-1]
        pose_covariance = own_last + by_robot @ covariance @ by_robot.T
        return own.reshape(count, STATE), robot, covariance, pose_covariance

    def alone(self, by_others: Array) -> tuple[Array, Array]:
        """Return what further unknowns would be (m,), each without the others, and their sd (m,).

        Args:
            by_others: (n, m) derivatives of the misses by them, in standard deviations.
        """
        seen, count = self.misses, len(self._own)
        size, others = count * STATE, by_others.shape[1]
        weighted = self._root * by_others
        rows = np.concatenate([seen.by_pose, seen.by_unknowns], axis=1) * self._root
        tied = np.zeros((count, rows.shape[1], others))
        starts = np.searchsorted(seen.picture, np.arange(count + 1))
        for k in np.flatnonzero(np.diff(starts)):
            some = slice(starts[k], starts[k + 1])
            tied[k] = rows[some].T @ weighted[some]
        by_pictures = np.zeros((count, STATE, others))
        by_pictures[:, :3] = tied[:, :3]
        own, by_robot = by_pictures.reshape(size, others), tied[:, 3:].sum(axis=0)
        shared = self._shared.reshape(size, self._unknowns)
        factor = self._factor(), True
        right = self._right.reshape(size)
        columns = np.column_stack([shared, own, right])
        solved = cho_solve_banded(factor, columns, check_finite=False)
        schur = self._robot - shared.T @ solved[:, : self._unknowns]
        by_robot = by_robot - shared.T @ solved[:, self._unknowns : -1]
        robot = np.linalg.solve(schur, by_robot)
        known = np.einsum("ij,ij->j", own, solved[:, self._unknowns : -1])
        known += np.einsum("ij,ij->j", by_robot, robot)
        information = np.square(weighted).sum(axis=0) - known
        pulls = -weighted.T @ (self._root[:, 0] * seen.residuals)
        # The solution is never quite reached: what all others would still give way is no pull.
        pulls -= own.T @ solved[:, -1] + robot.T @ (self._robot_right - shared.T @ solved[:, -1])
        # Of one that no edge tells, nothing is said.
        information = np.maximum(information, LEAST_INFORMATION)
        return pulls / information, 1 / np.sqrt(information)

    def _factor(self) -> Array:
        """Return Cholesky's factor of the pictures' equations, in bands."""
        size = len(self._own) * STATE
        band = np.zeros((BAND + 1, size))
        for row in range(STATE):
            for column in range(row + 1):
                band[row - column, column::STATE] = self._own[:, row, column]
            for column in range(STATE):
                # Entry (next row, this column), below the diagonal.
                below = row + STATE - column
                band[below, column : size - STATE : STATE] = self._next[:-1, column, row]
        factor: Array = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        return factor


@compiled()
def _add_rows(
    picture: NDArray[np.int64],
    by_pose: Array,
    by_robot: Array,
    map_unknowns: NDArray[np.intp],
    by_map: Array,
    residuals: Array,
    own: Array,
    shared: Array,
    robot: Array,
    right: Array,
    robot_right: Array,
) -> None:
    """Add the products of the rows of Jacobian and residuals; most of a row is zero."""
    most = by_robot.shape[1] + by_map.shape[1]
    columns, values = np.empty(most, np.int64), np.empty(most)
    for i in range(len(picture)):
        k = picture[i]
        count = _nonzero(by_robot[i], map_unknowns[i], by_map[i], columns, values)
        for a in range(3):
            for b in range(3):
                own[k, a, b] += by_pose[i, a] * by_pose[i, b]
            right[k, a] -= by_pose[i, a] * residuals[i]
        for m in range(count):
            for a in range(3):
                shared[k, a, columns[m]] += by_pose[i, a] * values[m]
            robot_right[columns[m]] -= values[m] * residuals[i]
            for n in range(count):
                robot[columns[m], columns[n]] += values[m] * values[n]


@compiled()
def _nonzero(
    by_robot: Array,
    map_unknowns: NDArray[np.intp],
    by_map: Array,
    columns: NDArray[np.int64],
    values: Array,
) -> int:
    """Write the shared unknowns that one row depends on, and its derivatives; return how many."""
    count = 0
    for j in range(len(by_robot)):
        if by_robot[j] != 0:
            columns[count], values[count] = j, by_robot[j]
            count += 1
    for j in range(len(by_map)):
        if by_map[j] != 0:
            columns[count], values[count] = len(by_robot) + map_unknowns[j], by_map[j]
            count += 1
    return count
