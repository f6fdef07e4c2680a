"""Adjusts the path of a drive and the robot's unknowns together, by least squares.

Each picture has five unknowns of its own: the robot's pose, and the slip of both wheels until the
next picture. They are tied to those of the next picture only, so their normal equations are banded.
The robot's unknowns are in all pictures; they are solved for first (Schur complement; Triggs et al.
2000, section 6.1). Its inverse is their covariance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.spatial.transform import Rotation

from robot.calibration.sightings import Misses, Sightings, misses
from robot.calibration.unknowns import (
    COUNT,
    DELAY,
    LEFT,
    PRIORS,
    RIGHT,
    ROTATION,
    SEPARATION,
)
from robot.calibration.wheel_motion import (
    BY_DELAY,
    BY_LEFT,
    BY_RIGHT,
    BY_SEPARATION,
    WheelMotion,
)
from robot.errors import BrickPoseError
from robot.geometry import Array, wrap_angle

STATE = 5
"""Unknowns of a picture: x, y, theta, left slip, right slip."""
BAND = 2 * STATE - 1

STEP_SD = np.array([0.00018, 0.00006, 0.0022])
"""Standard deviation of the motion between two pictures by the wheels, slip apart: the encoders
count in degrees [m, m, rad]."""
PARTS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
"""Parts of a step that are tried, until one lowers the cost."""
STILL = 0.03
"""The solution is found if no unknown changes by more than this share of its deviation."""
TYPICAL_SD = 0.0002
"""Standard deviation of most edges on the floor [m]."""
UNSETTLED = (
    "no robot and no path explain the drive: the robot did not start where it was told, it was "
    "moved by hand, or this is another field"
)
CAUCHY = 3.0
"""Distance from which on an edge counts less, in standard deviations."""
SLIP_SD, SLIP_TIME = 0.04, 1.0
"""Standard deviation of a wheel's slip, and the time over which it forgets what it was [s]."""


class CalibrationError(BrickPoseError, ValueError):
    """The drive does not tell what the robot is like; the message says why."""


@dataclass(frozen=True)
class Weights:
    """How much to believe while the unknowns are still far off."""

    stiffness: Array = field(default_factory=lambda: np.ones(COUNT), repr=False)
    """(15,) factors of the standard deviations of the priors."""
    gate: float = 0.02
    """Edges farther off than this do not count [m]."""
    doubt: float = 1.0
    """Factor of the edges' standard deviations."""


@dataclass
class State:
    """A drive's path and the robot's unknowns, as far as they are known."""

    values: Array
    """(15,) differences from the description."""
    poses: Array
    """(k, 3) in the map at each picture [m, m, rad]."""
    slip: Array
    """(k, 2) of the left and right wheel, until the next picture."""


@dataclass(frozen=True)
class Solution:
    """What one adjustment found."""

    state: State
    covariance: Array = field(repr=False)
    """(15, 11) of the unknowns."""
    pose_covariance: Array = field(repr=False)
    """(3, 3) of the last pose, with the unknowns' share."""
    misses: Misses = field(repr=False)
    cost: float


class Adjustment:
    """The least-squares problem of one drive."""

    def __init__(
        self, seen: Sightings, motion: WheelMotion, start: Array, start_covariance: Array
    ) -> None:
        """Prepare it; the start (3,) is where the robot was at the first picture, as told."""
        self._seen = seen
        self._motion = motion
        self._start = start
        self._start_information = np.asarray(np.linalg.inv(start_covariance), np.float64)

    def solve(self, state: State, weights: Weights, most: int = 30) -> Solution:
        """Improve a state until it changes no more (Gauss-Newton).

        Args:
            state: where to begin.
            weights: how much to believe.
            most: most iterations.

        Raises:
            CalibrationError: the errors grow without end.
        """
        equations = self._equations(state, weights, None)
        for _ in range(most):
            try:
                step, shared, covariance, pose_covariance = equations.solve()
            except np.linalg.LinAlgError:
                raise CalibrationError(UNSETTLED) from None
            if not np.isfinite(step).all():
                raise CalibrationError(UNSETTLED)
            before = equations
            # Far from the solution, a whole step may lead farther away.
            for part in PARTS:
                moved = _moved(state, part * step, part * shared)
                equations = self._equations(moved, weights, before.misses.pixels)
                if equations.cost <= before.cost:
                    break
            state = moved
            still = (np.abs(shared) / np.sqrt(np.diag(covariance))).max() < STILL
            # An edge at the border of the gate may come and go for ever.
            if still or abs(before.cost - equations.cost) < 1e-4 * equations.cost:
                break
        return Solution(state, covariance, pose_covariance, equations.misses, equations.cost)

    def _equations(self, state: State, weights: Weights, errors: Array | None) -> Equations:
        equations = Equations(len(state.poses))
        floor = self._seen.floor_points(state.values, self._motion.twists(state.values), errors)
        seen = misses(self._seen, floor, state.poses, state.values, weights.gate)
        equations.add_sightings(seen, weights.doubt)
        # An edge out of the gate costs as much as one at its border: else losing edges would pay.
        lost = int(np.isfinite(self._seen.pixels[:, :, 0]).sum()) - len(seen.residuals)
        at_gate = weights.gate / (TYPICAL_SD * weights.doubt * CAUCHY)
        equations.cost += lost * CAUCHY**2 * math.log1p(at_gate**2)
        equations.add_pairs(*self._step_errors(state))
        equations.add_slip(state.slip, self._motion.stamps)
        equations.add_start(state.poses[0], self._start, self._start_information)
        equations.add_prior(state.values, PRIORS * weights.stiffness)
        return equations

    def _step_errors(self, state: State) -> tuple[Array, Array, Array, Array]:
        """Return errors of the steps (k - 1, 3), and their derivatives, in standard deviations.

        The derivatives are by a picture's own unknowns (k - 1, 3, 5), by those of the next picture
        and by the robot's unknowns (k - 1, 3, 15).
        """
        steps, by_wheels = self._motion.steps(state.values, state.slip[:-1])
        before, after = state.poses[:-1], state.poses[1:]
        c, s = np.cos(before[:, 2]), np.sin(before[:, 2])
        dx, dy = (after - before)[:, :2].T
        local = np.column_stack([c * dx + s * dy, -s * dx + c * dy])
        error = np.column_stack([local, after[:, 2] - before[:, 2]]) - steps
        error[:, 2] = wrap_angle(error[:, 2])
        # The encoders' noise is of angles: on the floor it grows with the wheels. If it were
        # constant on the floor, a smaller world would always fit better.
        left, right, wider = state.values[[LEFT, RIGHT, SEPARATION]]
        larger = 1 + (left + right) / 2
        sd = STEP_SD * larger * np.array([1, 1, 1 / (1 + wider)])
        error /= sd
        by_wheels = -by_wheels / sd[:, None]
        robot = np.zeros((len(steps), 3, COUNT))
        robot[:, :, [LEFT, RIGHT]] = by_wheels[:, :, [BY_LEFT, BY_RIGHT]]
        robot[:, :, [LEFT, RIGHT]] -= (error / (2 * larger))[:, :, None]
        robot[:, :, SEPARATION] = by_wheels[:, :, BY_SEPARATION]
        robot[:, 2, SEPARATION] += error[:, 2] / (1 + wider)
        robot[:, :, DELAY] = by_wheels[:, :, BY_DELAY]
        by_after = np.zeros((len(steps), 3, STATE))
        by_after[:, 0, 0], by_after[:, 0, 1] = c, s
        by_after[:, 1, 0], by_after[:, 1, 1] = -s, c
        by_after[:, 2, 2] = 1
        by_before = -by_after
        by_before[:, 0, 2], by_before[:, 1, 2] = local[:, 1], -local[:, 0]
        by_after /= sd[:, None]
        by_before /= sd[:, None]
        by_before[:, :, 3:] = -by_wheels[:, :, [BY_LEFT, BY_RIGHT]]
        return error, by_before, by_after, robot


class Equations:
    """Normal equations: a chain of pictures, each also tied to the robot's unknowns."""

    def __init__(self, count: int) -> None:
        self._own = np.zeros((count, STATE, STATE))
        self._next = np.zeros((count, STATE, STATE))
        """From each picture (rows) to the next one (columns)."""
        self._shared = np.zeros((count, STATE, COUNT))
        self._robot = np.zeros((COUNT, COUNT))
        self._right = np.zeros((count, STATE))
        self._robot_right = np.zeros(COUNT)
        self.cost = 0.0
        self.misses: Misses

    def add_sightings(self, seen: Misses, doubt: float) -> None:
        """Add the edges that were seen, with Cauchy's weights and a factor of their deviations."""
        self.misses = seen
        squares = (seen.residuals / (CAUCHY * doubt)) ** 2
        self.cost += float(CAUCHY**2 * np.log1p(squares).sum())
        root = (1 / np.sqrt(1 + squares) / doubt)[:, None]
        robot, residuals = root * seen.by_unknowns, root * seen.residuals[:, None]
        rows = np.concatenate([root * seen.by_pose, robot, residuals], axis=1)
        # All products of a picture's rows at once; the pictures' rows follow each other.
        starts = np.searchsorted(seen.picture, np.arange(len(self._own) + 1))
        for k in np.flatnonzero(np.diff(starts)):
            part = rows[starts[k] : starts[k + 1]]
            products = part.T @ part
            self._own[k, :3, :3] += products[:3, :3]
            self._shared[k, :3] += products[:3, 3:-1]
            self._right[k, :3] -= products[:3, -1]
        self._robot += robot.T @ robot
        self._robot_right -= robot.T @ residuals[:, 0]

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
        self._shared[:-1] += own.transpose(0, 2, 1) @ robot
        self._shared[1:] += following.transpose(0, 2, 1) @ robot
        self._right[:-1] -= np.einsum("nij,ni->nj", own, error)
        self._right[1:] -= np.einsum("nij,ni->nj", following, error)
        flat = robot.reshape(-1, COUNT)
        self._robot += flat.T @ flat
        self._robot_right -= flat.T @ error.reshape(-1)

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

    def add_prior(self, values: Array, sd: Array) -> None:
        """Add that the robot is much as described."""
        self._robot[np.diag_indices(COUNT)] += 1 / sd**2
        self._robot_right -= values / sd**2
        self.cost += float(((values / sd) ** 2).sum())

    def solve(self) -> tuple[Array, Array, Array, Array]:
        """Return the steps (k, 5) and (15,), the latter's covariance, and the last pose's."""
        count = len(self._own)
        size = count * STATE
        band = np.zeros((BAND + 1, size))
        for row in range(STATE):
            for column in range(row + 1):
                band[row - column, column::STATE] = self._own[:, row, column]
            for column in range(STATE):
                # Entry (next row, this column), below the diagonal.
                below = row + STATE - column
                band[below, column : size - STATE : STATE] = self._next[:-1, column, row]
        factor = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        shared = self._shared.reshape(size, COUNT)
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


def _moved(state: State, step: Array, shared: Array) -> State:
    values = state.values + shared
    turned = Rotation.from_rotvec(shared[ROTATION]) * Rotation.from_rotvec(state.values[ROTATION])
    values[ROTATION] = turned.as_rotvec()
    poses = state.poses + step[:, :3]
    poses[:, 2] = wrap_angle(poses[:, 2])
    return State(values, poses, state.slip + step[:, 3:])


def residual_sd(seen: Misses) -> float:
    """Return the robust standard deviation of the misses, in those that were expected."""
    return float(np.median(np.abs(seen.residuals)) / 0.6745) if len(seen.residuals) else math.nan
