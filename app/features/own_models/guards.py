"""Guards between the filter and a user's own models: a faulty model does not harm the filter.

``fault`` keeps a failure, and the model is not called again. The filter then gets neutral values:
the same likelihood for every pose, and odometry without noise.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from app.features.own_models.error_messages import OwnModelError, errors_named_after, line_of
from app.features.own_models.model_file import ModelFile, build, load
from app.languages.marking import phrase
from robot.geometry import Array, Pose2, compose, wrap_angle
from robot.localization.models.motion_models import sampled_moments
from robot.scan import Scan

TRIED = np.array([[0.0, 0.0, 0.0], [0.01, 0.02, 0.1]])
"""Offsets from the start pose at which a model is tried out."""

LARGEST = 1e9
"""Larger numbers are a mistake, and the filter's sums could not hold them."""


class Guard:
    """Calls one method of a user's model and checks its result."""

    def __init__(self, file: ModelFile, model: object, method: str, fault: str | None) -> None:
        self.fault = fault
        """What went wrong, with file and line; None while nothing did."""
        self.trace = ""
        """The calls that led there, if it went wrong within the user's file."""
        self.seconds = 0.0
        """How long the last call took [s]."""
        self.passed_over = 0
        """The filter's updates since the method was last called."""
        self._path = file.path
        self._name = method
        self._method: Callable[..., Any] | None = getattr(model, method, None)
        self._line = line_of(self._method, file.path)
        if fault is None and not callable(self._method):
            self.fault = phrase(f"{file.path.name}: {file.class_name} has no method {method}")

    def call(self, shape: tuple[int, ...], *arguments: object) -> Array | None:
        """Return the method's result of the given shape; None once something went wrong."""
        if self.fault is not None or self._method is None:
            return None
        self.passed_over = 0
        began = time.perf_counter()
        try:
            with errors_named_after(self._path, self._line):
                given = self._method(*arguments)
                result = self._checked(given, shape)
        except OwnModelError as error:
            self.fault, self.trace = str(error), error.trace
            return None
        self.seconds = time.perf_counter() - began
        return result

    def _checked(self, given: object, shape: tuple[int, ...]) -> Array:
        if given is None:
            raise OwnModelError(f"{self._name} gives None; is its `return` missing?")
        # A copy, as the model may still write to its own array.
        result = np.array(given, dtype=np.float64)
        if result.shape != shape:
            raise OwnModelError(f"{self._name} gives the shape {result.shape}; valid is {shape}")
        wrong = ~(np.abs(result) <= LARGEST)
        if wrong.any():
            raise OwnModelError(
                f"{self._name} gives {result[wrong].flat[0]} for {wrong.sum()} of "
                f"{wrong.size} poses; valid are finite numbers up to {LARGEST:.0f}"
            )
        return result


class OwnSensor:
    """A user's own sensor model."""

    is_part = True  # of snapshots that go to another process: it is sent once

    def __init__(self, file: ModelFile, model: object, fault: str | None = None) -> None:
        self.guard = Guard(file, model, "log_likelihood", fault)
        self.made_of: Mapping[str, object] | None = None
        """What the file's class was given; None if it is no class of a user's file."""
        self._file = file

    def elsewhere(self) -> tuple[Callable[..., OwnSensor], tuple[object, ...]] | None:
        """Return a function and arguments that make it in another process; None: it is pickled.

        The other process has no module of the user's file.
        """
        if self.made_of is None:
            return None
        return _made_again, (self._file, dict(self.made_of), self.guard.fault)

    @property
    def fault(self) -> str | None:
        """What went wrong, with file and line; None while nothing did."""
        return self.guard.fault

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3); zeros once the model has failed."""
        # Copies: a mistake in the model must not change the scan that others use, nor the arrays
        # that all scans share.
        own = replace(
            scan,
            bearings=scan.bearings.copy(),
            ranges=scan.ranges.copy(),
            sight=None if scan.sight is None else scan.sight.copy(),
            clear=None if scan.clear is None else scan.clear.copy(),
            hidden=None if scan.hidden is None else scan.hidden.copy(),
        )
        result = self.guard.call((len(poses),), poses.copy(), own)
        return np.zeros(len(poses)) if result is None else result

    def apart(self) -> OwnSensor:
        """Return the same model with a guard of its own: a failure there stops no robot."""
        other = OwnSensor.__new__(OwnSensor)
        vars(other).update(vars(self), guard=copy(self.guard))
        return other

    def try_out(self, start: Pose2) -> None:
        """Ask once, so that mistakes show (and numba compiles) before the robot drives."""
        ranges = np.array([0.3, np.inf, 0.25, 0.2])
        sight = np.tile([0.1, 1.0], (4, 1))
        scan = Scan(0.0, np.linspace(-0.5, 0.5, 4), ranges, sight=sight)
        self.log_likelihood(start.to_array() + TRIED, scan)


class OwnMotion:
    """A user's own motion model."""

    def __init__(self, file: ModelFile, model: object, fault: str | None = None) -> None:
        self.guard = Guard(file, model, "sample", fault)
        self.made_of: Mapping[str, object] | None = None
        """What the file's class was given; None if it is no class of a user's file."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Sample each particle's new pose (n, 3); odometry alone once the model has failed."""
        result = self.guard.call(poses.shape, poses.copy(), moved, rng)
        if result is None:
            return compose(poses, moved.to_array())
        result[:, 2] = wrap_angle(result[:, 2])
        return result

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance of a step, from samples, even if the model has its own moments."""
        return sampled_moments(self.sample, moved)

    def try_out(self, start: Pose2) -> None:
        """Ask once, so that mistakes show (and numba compiles) before the robot drives."""
        poses = start.to_array() + TRIED
        self.sample(poses, Pose2(0.005, 0.0, 0.01), np.random.default_rng(0))


def _made_again(file: ModelFile, made_of: Mapping[str, object], fault: str | None) -> OwnSensor:
    """Return a user's sensor model as another process has it."""
    try:
        return OwnSensor(file, build(file, load(file), made_of), fault)
    except OwnModelError as error:
        return OwnSensor(file, None, str(error))
