"""How likely errors are whose covariance is a sum of known parts, each by a factor to be found."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from robot.geometry import Array

SMALLEST, LARGEST = math.log(1e-13), math.log(1e5)
"""Logarithms of factors that are tried; metres and radians, so none is near either end."""


@dataclass(frozen=True, eq=False)
class VarianceParts:
    """Normal errors without bias, whose covariance is the sum of factors (c,) times parts.

    Factors are sought as logarithms, so that none becomes negative.
    """

    errors: Array
    """(n, 3)"""
    parts: Array
    """(n, c, 3, 3)"""
    weight: float
    """What each error counts: below one where errors repeat each other."""

    def covariances(self, logs: Array) -> Array:
        """(n, 3, 3) with factors of these logarithms (c,)."""
        whole: Array = np.einsum("c,ncij->nij", np.exp(logs), self.parts)
        return whole

    def value(self, logs: Array) -> float:
        """Minus the logarithm of the likelihood."""
        covariances = self.covariances(logs)
        _, logdets = np.linalg.slogdet(covariances)
        pulls = np.linalg.solve(covariances, self.errors[..., None])[..., 0]
        terms = np.sum(self.errors * pulls, axis=1) + logdets + 3 * math.log(2 * math.pi)
        return 0.5 * self.weight * float(terms.sum())

    def value_and_gradient(self, logs: Array) -> tuple[float, Array]:
        """Minus the logarithm of the likelihood, and what it changes by with logs (c,)."""
        inverse = np.linalg.inv(self.covariances(logs))
        pulls = np.einsum("nij,nj->ni", inverse, self.errors)
        _, logdets = np.linalg.slogdet(inverse)
        terms = np.sum(self.errors * pulls, axis=1) - logdets + 3 * math.log(2 * math.pi)
        excess = inverse - pulls[:, :, None] * pulls[:, None, :]
        gradient = np.tensordot(excess, self.parts.swapaxes(0, 1), axes=([0, 1, 2], [1, 2, 3]))
        half = 0.5 * self.weight
        return half * float(terms.sum()), half * np.exp(logs) * gradient

    def information(self, logs: Array) -> Array:
        """(c, c): the second derivatives of minus the logarithm of the likelihood, by logs."""
        inverse = np.linalg.inv(self.covariances(logs))
        pulls = np.einsum("nij,nj->ni", inverse, self.errors)
        scaled = np.exp(logs)[:, None, None] * self.parts
        shares = inverse[:, None] @ scaled
        pulled = np.einsum("ncij,nj->nci", scaled, pulls)
        by_factors = np.einsum("nai,nij,nbj->ab", pulled, inverse, pulled) - 0.5 * np.einsum(
            "naij,nbji->ab", shares, shares
        )
        _, gradient = self.value_and_gradient(logs)
        whole: Array = self.weight * by_factors + np.diag(gradient)
        return whole

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
        would not come back; so those are tried once more from where they matter a little.
        """
        matters = self.start() - 5
        value, found = self._descend(self._above(logs, matters, fixed), fixed)
        if (found < matters).any():
            again = self._descend(self._above(found, matters, fixed), fixed)
            return min((value, found), again, key=lambda result: result[0])
        return value, found

    def _descend(self, logs: Array, fixed: int | None) -> tuple[float, Array]:
        bounds = [(SMALLEST, LARGEST)] * len(logs)
        if fixed is not None:
            bounds[fixed] = (logs[fixed], logs[fixed])
        found = minimize(
            self.value_and_gradient, logs, jac=True, method="L-BFGS-B", bounds=bounds,
            options={"ftol": 1e-11, "gtol": 1e-7, "maxiter": 500},
        )  # fmt: skip
        return float(found.fun), np.asarray(found.x)

    def _above(self, logs: Array, least: Array, fixed: int | None) -> Array:
        raised = np.maximum(logs, least)
        if fixed is not None:
            raised[fixed] = logs[fixed]
        return raised
