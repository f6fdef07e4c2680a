"""Adjusts the path of a drive and the robot's unknowns together, by least squares.

Gauss-Newton: the errors of edges, wheels and priors are written as normal equations
(``normal_equations``), and each solution is the next state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from robot.calibration.misses import Misses, misses
from robot.calibration.normal_equations import CAUCHY, STATE, Equations
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import (
    BY_DELAY,
    BY_LEFT,
    BY_RIGHT,
    BY_SEPARATION,
    BY_SLIP,
    WheelMotion,
)
from robot.description.unknowns import (
    COUNT,
    DELAY,
    LEFT,
    NAMES,
    PRIORS,
    RIGHT,
    ROTATION,
    SEPARATION,
)
from robot.errors import BrickPoseError
from robot.estimation.fit_quality import FitQuality, correlation_of, overruns, robust_sd
from robot.geometry import Array, wrap_angle

STEP_SD = np.array([0.00018, 0.00006, 0.0022])
"""Standard deviation of the motion between two pictures by the wheels, slip apart: the encoders
count in degrees [m, m, rad]."""
PARTS = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)
"""Parts of a step that are tried, until one lowers the cost."""
STILL = 0.03
"""The solution is found if no unknown changes by more than this share of its deviation."""
NO_ROBOT = 30.0
"""An unknown farther off than this many standard deviations of its prior is of no real robot."""
SAME_COST = 0.1
"""... or if the cost changes by less: that is a third of a standard deviation of one unknown."""
TYPICAL_SD = 0.0002
"""Standard deviation of most edges on the floor [m]."""
UNSETTLED = (
    "no robot and no path explain the drive: the robot did not start where it was told, it was "
    "moved by hand, or this is another field"
)


class CalibrationError(BrickPoseError, ValueError):
    """The drive does not tell what the robot is like; the message says why."""


@dataclass(frozen=True, eq=False)
class Weights:
    """How much to believe while the unknowns are still far off."""

    mean: Array = field(default_factory=lambda: np.zeros(COUNT), repr=False)
    """(15,) what the unknowns are, before the drive is looked at."""
    sd: Array = field(default_factory=PRIORS.copy, repr=False)
    """(15,) and their standard deviations."""
    gate: float = 0.02
    """Edges farther off than this do not count [m]."""
    doubt: float = 1.0
    """Factor of the edges' standard deviations."""
    covariance: Array | None = field(default=None, repr=False)
    """(15, 15) of the unknowns before the drive, instead of ``sd`` where they are correlated."""

    @cached_property
    def information(self) -> Array:
        """(15, 15) on the unknowns, before the drive is looked at."""
        if self.covariance is None:
            return np.diag(self.sd**-2)
        return np.asarray(np.linalg.inv(self.covariance), np.float64)


@dataclass(eq=False)
class DriveEstimate:
    """A drive's path and the robot's unknowns, as far as they are known."""

    values: Array
    """(15,) differences from the description."""
    poses: Array
    """(k, 3) in the map at each picture [m, m, rad]."""
    slip: Array
    """(k, 2) of the left and right wheel, until the next picture (see ``WheelMotion.steps``)."""
    map: Array = field(default_factory=lambda: np.zeros(0))
    """(u,) unknowns of the map (``TapeEdges.derivatives``) [m]; none if the map is known."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What one adjustment found."""

    state: DriveEstimate
    covariance: Array = field(repr=False)
    """(15, 15) of the unknowns; those of the map follow."""
    pose_covariance: Array = field(repr=False)
    """(3, 3) of the last pose, with the unknowns' share."""
    misses: Misses = field(repr=False)
    cost: float
    """Sum of the squared errors, robust, in standard deviations."""
    share: float
    """Of the edges that were seen, those that lie near the field's."""
    converged: bool = True
    """Whether a further step would change nothing; else the covariance is too small."""


class Adjustment:
    """The least-squares problem of one drive."""

    def __init__(
        self, seen: Sightings, motion: WheelMotion, start: Array, start_covariance: Array
    ) -> None:
        """Prepare it; the start (3,) is where the robot was at the first picture, as told."""
        self._seen = seen
        self._count = int(np.isfinite(seen.pixels[:, :, 0]).sum())
        self._motion = motion
        self._start = start
        self._start_information = np.asarray(np.linalg.inv(start_covariance), np.float64)

    def solve(
        self, state: DriveEstimate, weights: Weights, most: int = 30, errors: Array | None = None
    ) -> Solution:
        """Improve a state until it changes no more (Gauss-Newton).

        Args:
            state: where to begin.
            weights: how much to believe.
            most: most iterations.
            errors: the pixels' errors at about that state, from an earlier solution, if known.

        Raises:
            CalibrationError: the errors grow without end.
        """
        # The pixels' errors are known when edges were matched; without, even one step leads astray.
        if errors is None:
            errors = self._equations(state, weights, None).misses.pixels
        equations, converged = self._equations(state, weights, errors), False
        changes: list[tuple[float, float]] = []
        for _ in range(most):
            try:
                step, shared, covariance, pose_covariance = equations.solve()
            except np.linalg.LinAlgError:
                raise CalibrationError(UNSETTLED) from None
            if not np.isfinite(step).all():
                raise CalibrationError(UNSETTLED)
            before = equations
            moves = float((np.abs(shared) / np.sqrt(np.diag(covariance))).max())
            # Far from the solution, a whole step may lead farther away.
            for part in PARTS:
                moved = _moved(state, part * step, part * shared)
                if (np.abs(moved.values) >= NO_ROBOT * PRIORS).any():
                    continue
                equations = self._equations(moved, weights, before.misses.pixels)
                change = self._change(before, equations, weights)
                if self._takes(change, moves):
                    break
            if equations is before:
                raise CalibrationError(UNSETTLED)
            state = moved
            changes.append((part, change))
            if moves < STILL or self._ends(changes):
                converged = True
                break
        share = len(equations.misses.residuals) / max(1, self._counting(equations.misses))
        seen, cost = equations.misses, equations.cost
        return Solution(state, covariance, pose_covariance, seen, cost, share, converged)

    def _change(self, before: Equations, after: Equations, weights: Weights) -> float:
        """Return by how much a step changed the cost."""
        return after.cost - before.cost

    def _takes(self, change: float, moves: float) -> bool:
        """Return whether a step is taken that changes the cost.

        It moves the unknowns by a number of their standard deviations at most.
        """
        return change <= 0

    def _ends(self, changes: Sequence[tuple[float, float]]) -> bool:
        """Return whether nothing changes any more; of each step its part, and the cost's change."""
        # An edge at the border of the gate may come and go for ever.
        return abs(changes[-1][1]) < SAME_COST

    def alone(
        self, solution: Solution, weights: Weights, by_others: Callable[[Misses], Array]
    ) -> tuple[Array, Array]:
        """Return what further unknowns would be (``Equations.alone``), at a solution.

        Args:
            solution: where.
            weights: how much to believe.
            by_others: returns the derivatives of misses by them. An edge at the border of the gate
                may be in these misses, and not in the solution's.
        """
        equations = self._equations(solution.state, weights, solution.misses.pixels)
        return equations.alone(by_others(equations.misses))

    def _equations(self, state: DriveEstimate, weights: Weights, errors: Array | None) -> Equations:
        sightings = self._sightings(state)
        equations = Equations(len(state.poses), COUNT + sightings.tape.unknowns)
        equations.tape = sightings.tape
        twists = self._motion.twists(state.values, state.slip)
        seen = self._add_sightings(equations, sightings, twists, state, weights, errors)
        # An edge out of the gate costs as much as one at its border: else losing edges would pay.
        lost = self._counting(seen) - len(seen.residuals)
        equations.lost_cost = lost * cost_at_gate(weights)
        equations.cost += equations.lost_cost
        equations.add_pairs(*self._step_errors(state))
        equations.add_slip(state.slip, self._motion.stamps)
        equations.add_start(state.poses[0], self._start, self._start_information)
        equations.add_prior(*self._prior(state, weights))
        return equations

    def _add_sightings(
        self,
        equations: Equations,
        sightings: Sightings,
        twists: Array,
        state: DriveEstimate,
        weights: Weights,
        errors: Array | None,
    ) -> Misses:
        """Add what was seen to the equations, and return how far it is off."""
        floor = sightings.floor_points(state.values, twists, errors)
        seen = misses(sightings, floor, state.poses, state.values, weights.gate)
        equations.add_sightings(seen, weights.doubt)
        return seen

    def step_errors(self, state: DriveEstimate) -> Array:
        """Return how far each step is from what the wheels tell (k - 1, 3), in deviations."""
        return self._step_errors(state)[0]

    def _sightings(self, state: DriveEstimate) -> Sightings:
        """Return the sightings, with the edges where they are in a state."""
        return self._seen

    def _prior(self, state: DriveEstimate, weights: Weights) -> tuple[Array, Array]:
        """Return how the shared unknowns (s,) differ from the expected, and the information."""
        return state.values - weights.mean, weights.information

    def _counting(self, seen: Misses) -> int:
        """Return how many edges should lie on the field's: nobody measures at their ends."""
        return self._count - int(seen.near_ends.sum())

    def _step_errors(self, state: DriveEstimate) -> tuple[Array, Array, Array, Array]:
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
        by_wheels = -(by_wheels + self._motion.by_errors(state.values, steps, error))
        sd = step_sd(state.values)
        error /= sd
        by_wheels /= sd[:, None]
        robot = np.zeros((len(steps), 3, COUNT))
        robot[:, :, [LEFT, RIGHT]] = by_wheels[:, :, [BY_LEFT, BY_RIGHT]]
        robot[:, :, SEPARATION] = by_wheels[:, :, BY_SEPARATION]
        robot[:, :, DELAY] = by_wheels[:, :, BY_DELAY]
        by_after = np.zeros((len(steps), 3, STATE))
        by_after[:, 0, 0], by_after[:, 0, 1] = c, s
        by_after[:, 1, 0], by_after[:, 1, 1] = -s, c
        by_after[:, 2, 2] = 1
        by_before = -by_after
        by_before[:, 0, 2], by_before[:, 1, 2] = local[:, 1], -local[:, 0]
        by_after /= sd[:, None]
        by_before /= sd[:, None]
        by_before[:, :, 3:] = by_wheels[:, :, BY_SLIP]
        return error, by_before, by_after, robot


def step_sd(values: Array) -> Array:
    """Return the standard deviations of a step by the wheels (3,) [m, m, rad].

    The encoders' noise is of angles: on the floor it grows with the wheels.
    """
    larger = 1 + values[[LEFT, RIGHT]].mean()
    sd: Array = STEP_SD * (larger, larger, 1)
    return sd


def cost_at_gate(weights: Weights) -> float:
    """Return what an edge costs at the border of the gate."""
    at_gate = weights.gate / (TYPICAL_SD * weights.doubt * CAUCHY)
    return CAUCHY**2 * math.log1p(at_gate**2)


def _moved(state: DriveEstimate, step: Array, shared: Array) -> DriveEstimate:
    values = state.values + shared[:COUNT]
    turned = Rotation.from_rotvec(shared[ROTATION]) * Rotation.from_rotvec(state.values[ROTATION])
    values[ROTATION] = turned.as_rotvec()
    poses = state.poses + step[:, :3]
    poses[:, 2] = wrap_angle(poses[:, 2])
    return DriveEstimate(values, poses, state.slip + step[:, 3:], state.map + shared[COUNT:])


def residual_sd(seen: Misses) -> float:
    """Return the robust standard deviation of the misses, in those that were expected."""
    return robust_sd(seen.residuals)


def quality_of(
    solution: Solution, prior_sd: Array, unobservable: tuple[str, ...] = ()
) -> FitQuality:
    """Return how well a solution fits.

    Args:
        solution: of a drive.
        prior_sd: (15,) of the unknowns before it.
        unobservable: unknowns that the drive does not tell.
    """
    seen = solution.misses
    alike = correlation_of(np.clip(seen.residuals, -CAUCHY, CAUCHY), seen.picture)
    overrun = overruns(solution.state.values, prior_sd, NAMES)
    return FitQuality(residual_sd(seen), solution.converged, alike, overrun, unobservable)
