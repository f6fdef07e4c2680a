"""Between the filter and a user's own model: whatever that does, the filter goes on unharmed.

A failure is kept in ``fault`` and the model is not asked again. The filter is given what leaves
its belief as it is: no opinion of a scan, odometry without noise.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from app.engine.own_models.error_messages import OwnModelError, blaming, line_of
from app.engine.own_models.model_file import ModelFile
from robot.geometry import Array, Pose2, compose, wrap_angle
from robot.localization.models.motion_models import sampled_moments
from robot.scan import Scan

TRIED = np.array([[0.0, 0.0, 0.0], [0.01, 0.02, 0.1]])
"""Poses around the start at which a model is tried out."""

LARGEST = 1e9
"""Numbers beyond this are a mistake, and would not survive the filter's sums."""


class Guard:
    """Calls one method of a user's model and checks what it gives."""

    def __init__(self, file: ModelFile, model: object, method: str, fault: str | None) -> None:
        self.fault = fault
        """What went wrong, with file and line; None while nothing has."""
        self.seconds = 0.0
        """How long the last call took [s]."""
        self.passed_over = 0
        """Updates of the filter since it was last asked."""
        self._path = file.path
        self._name = method
        self._method: Callable[..., Any] | None = getattr(model, method, None)
        self._line = line_of(self._method, file.path)
        if fault is None and not callable(self._method):
            self.fault = f"{file.path.name}: {file.class_name} has no method {method}"

    def call(self, shape: tuple[int, ...], *arguments: object) -> Array | None:
        """What the model gives, of a shape; None once something went wrong."""
        if self.fault is not None or self._method is None:
            return None
        self.passed_over = 0
        began = time.perf_counter()
        try:
            with blaming(self._path, self._line):
                given = self._method(*arguments)
                result = self._checked(given, shape)
        except OwnModelError as error:
            self.fault = str(error)
            return None
        self.seconds = time.perf_counter() - began
        return result

    def _checked(self, given: object, shape: tuple[int, ...]) -> Array:
        if given is None:
            raise OwnModelError(f"{self._name} gives None; is its `return` missing?")
        # A copy: the model may go on writing into its own.
        result = np.array(given, dtype=np.float64)
        if result.shape != shape:
            raise OwnModelError(f"{self._name} gives the shape {result.shape}; valid is {shape}")
        wrong = ~(np.abs(result) <= LARGEST)
        if wrong.any():
            raise OwnModelError(
                f"{self._name} gives {result[wrong].flat[0]} in {wrong.sum()} of {wrong.size} "
                f"places; valid are finite numbers up to {LARGEST:g}"
            )
        return result


class OwnSensor:
    """A sensor model of a user's own."""

    def __init__(self, file: ModelFile, model: object, fault: str | None = None) -> None:
        self.guard = Guard(file, model, "log_likelihood", fault)

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3); no opinion once it has failed."""
        # Copies: a mistake in there must not change the scan that everybody sees, nor what is the
        # same for all scans.
        own = replace(
            scan,
            bearings=scan.bearings.copy(),
            ranges=scan.ranges.copy(),
            sight=None if scan.sight is None else scan.sight.copy(),
        )
        result = self.guard.call((len(poses),), poses.copy(), own)
        return np.zeros(len(poses)) if result is None else result

    def try_out(self, start: Pose2) -> None:
        """Ask once, so that mistakes show (and numba compiles) before the robot drives."""
        ranges = np.array([0.3, np.inf, 0.25, 0.2])
        sight = np.tile([0.1, 1.0], (4, 1))
        scan = Scan(0.0, np.linspace(-0.5, 0.5, 4), ranges, sight=sight)
        self.log_likelihood(start.to_array() + TRIED, scan)


class OwnMotion:
    """A motion model of a user's own."""

    def __init__(self, file: ModelFile, model: object, fault: str | None = None) -> None:
        self.guard = Guard(file, model, "sample", fault)

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Where each particle (n, 3) went; as odometry says once it has failed."""
        result = self.guard.call(poses.shape, poses.copy(), moved, rng)
        if result is None:
            return compose(poses, moved.to_array())
        result[:, 2] = wrap_angle(result[:, 2])
        return result

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance of where a step ends: by draws, whatever else the model offers."""
        return sampled_moments(self.sample, moved)

    def try_out(self, start: Pose2) -> None:
        """Ask once, so that mistakes show (and numba compiles) before the robot drives."""
        poses = start.to_array() + TRIED
        self.sample(poses, Pose2(0.005, 0.0, 0.01), np.random.default_rng(0))
