"""How likely errors are whose covariance is a sum of known parts, each by a factor to be found."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array

SMALLEST, LARGEST = math.log(1e-13), math.log(1e5)
"""Logarithms of factors that are tried; metres and radians, so none is near either end."""

ENOUGH = 1e-6
"""A step that gains less of the logarithm of the likelihood is the last."""

BOLDEST, MOST_STEPS = 3.0, 200
"""No logarithm changes by more in a step, and so many steps are never needed."""


@dataclass(frozen=True, eq=False)
class VarianceParts:
    """Normal errors without bias, whose covariance is the sum of factors (c,) times parts.

    Factors are sought as logarithms, so that none becomes negative.
    """

    errors: Array
    """(n, 3)"""
    parts: Array
    """(n, c, 3, 3)"""
    weights: Array
    """(n,): what each error counts; below one where errors repeat each other."""

    def covariances(self, logs: Array) -> Array:
        """(n, 3, 3) with factors of these logarithms (c,)."""
        whole: Array = np.einsum("c,ncij->nij", np.exp(logs), self.parts)
        return whole

    def value_and_gradient(self, logs: Array) -> tuple[float, Array]:
        """Minus the logarithm of the likelihood, and what it changes by with logs (c,)."""
        inverse = self._inverse(logs)
        return self._value(inverse), self._gradient(logs, inverse)

    def information(self, logs: Array) -> Array:
        """(c, c): the second derivatives of minus the logarithm of the likelihood, by logs."""
        inverse = self._inverse(logs)
        scaled = np.exp(logs)[:, None, None] * self.parts
        pulled = np.einsum("ncij,nj->nci", scaled, self._pulls(inverse))
        weighed = self.weights[:, None, None] * inverse
        of_errors = np.einsum("nai,nij,nbj->ab", pulled, weighed, pulled)
        curvature: Array = of_errors - self._expected(logs, inverse)
        return curvature + np.diag(self._gradient(logs, inverse))

    def _inverse(self, logs: Array) -> Array:
        return np.asarray(np.linalg.inv(self.covariances(logs)), dtype=np.float64)

    def _value(self, inverse: Array) -> float:
        terms = np.sum(self.errors * self._pulls(inverse), axis=1)
        terms += 3 * math.log(2 * math.pi) - np.linalg.slogdet(inverse)[1]
        return 0.5 * float(self.weights @ terms)

    def _gradient(self, logs: Array, inverse: Array) -> Array:
        pulls = self._pulls(inverse)
        excess = inverse - pulls[:, :, None] * pulls[:, None, :]
        excess = (self.weights[:, None, None] * excess).reshape(-1)
        by_factor = excess @ self.parts.swapaxes(0, 1).reshape(len(logs), -1).T
        gradient: Array = 0.5 * np.exp(logs) * by_factor
        return gradient

    def _expected(self, logs: Array, inverse: Array) -> Array:
        """(c, c): the information that errors of these covariances have on the mean (Fisher)."""
        shares = inverse[:, None] @ (np.exp(logs)[:, None, None] * self.parts)
        weighed = self.weights[:, None, None, None] * shares
        rows = weighed.swapaxes(0, 1).reshape(len(logs), -1)
        columns = shares.swapaxes(2, 3).swapaxes(0, 1).reshape(len(logs), -1)
        expected: Array = 0.5 * rows @ columns.T
        return expected

    def _pulls(self, inverse: Array) -> Array:
        pulls: Array = np.einsum("nij,nj->ni", inverse, self.errors)
        return pulls

    def start(self) -> Array:
        """Logarithms (c,) to begin with: each part explains as much as any other."""
        spread = self.errors.T @ self.errors / len(self.errors) + 1e-12 * np.eye(3)
        sizes = np.einsum("ij,ncji->c", np.linalg.inv(spread), self.parts) / len(self.errors)
        shares = 3 / (len(sizes) * np.maximum(sizes, 1e-12))
        logs: Array = np.clip(np.log(shares), SMALLEST, LARGEST)
        return logs

    def least(self, logs: Array, fixed: int | None = None) -> tuple[float, Array]:
        """The least value, and logs (c,) that give it, from some on; one of them may be kept.

        Near zero a factor's logarithm changes nothing, and one that went there by a bold step
        would not come back; so all begin where they matter a little, and the greatest of all
        likelihoods is sought twice.
        """
        matters = self.start() - 5
        value, found = self._descend(self._above(logs, matters, fixed), fixed)
        if fixed is None and (found < matters).any():
            again = self._descend(self._above(found, matters, fixed), fixed)
            return min((value, found), again, key=lambda result: result[0])
        return value, found

    def _descend(self, logs: Array, fixed: int | None) -> tuple[float, Array]:
        """Fisher scoring: Newton's steps with the expected information, damped where too bold."""
        free = np.arange(len(logs)) != fixed
        inverse, damping = self._inverse(logs), 1e-3
        value = self._value(inverse)
        for _ in range(MOST_STEPS):
            gradient = self._gradient(logs, inverse)[free]
            information = self._expected(logs, inverse)[np.ix_(free, free)]
            while damping < 1e9:
                damped = information + np.diag(damping * np.diag(information) + 1e-12)
                move = np.clip(np.linalg.solve(damped, -gradient), -BOLDEST, BOLDEST)
                trial = logs.copy()
                trial[free] = np.clip(logs[free] + move, SMALLEST, LARGEST)
                inverse = self._inverse(trial)
                reached = self._value(inverse)
                if reached <= value:
                    break
                damping *= 10
            if reached > value or value - reached < ENOUGH:
                break
            value, logs, damping = reached, trial, max(damping / 10, 1e-6)
        return value, logs

    def _above(self, logs: Array, least: Array, fixed: int | None) -> Array:
        raised = np.maximum(logs, least)
        if fixed is not None:
            raised[fixed] = logs[fixed]
        return raised
