"""Companions of an engine: what features do in each tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from types import MappingProxyType
from typing import Protocol

from app.engine.controls import Controls
from app.engine.problems import LOG
from app.languages.marking import phrase
from app.messages.commands import Command
from app.settings.config import Config
from robot.errors import one_line
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, Robot


class Companion(Protocol):
    """Goes along with one engine, in its thread: long work belongs into another thread.

    It may have an attribute ``shown`` besides, a value that nobody changes any more: each
    ``Snapshot`` has it in ``added``, by the feature's name, for values, topics and telemetry. And
    an attribute ``needs_pictures``: while it is true, the camera does not rest.
    """

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Return commands that the engine shall carry out now, after those of clients.

        Args:
            odom_from_robot: dead reckoning now.
            controls: robot, odometry, filter and driving; commands change them, and not this.
        """
        ...

    def add(self, reading: Reading, controls: Controls) -> None:
        """Look at a reading, after scanner and filter have used its picture.

        While the robot rests, there are five pictures a second, and ten readings of a simulation.
        """
        ...

    def close(self) -> None:
        """End; may be called twice."""
        ...


NewCompanion = Callable[[Config, Robot, Field], Iterable[Companion]]
"""Makes companions of an engine, as far as its settings want any."""


class Companions:
    """All companions of one engine; one that fails is told, and left out from then on."""

    def __init__(
        self,
        companions: Iterable[tuple[str, Companion]] = (),
        failures: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Take companions with the names of their features, and why those of some are missing."""
        self._each = tuple(companions)
        self._failures = failures
        """To be reported with the first tick."""

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> tuple[Command, ...]:
        """Return the commands of all of them."""
        for name, failure in self._failures.items():
            controls.report(name, failure)
        self._failures = {}
        given: list[Command] = []
        for name, companion in self._each:
            try:
                given += companion.commands(odom_from_robot, controls)
            except Exception as error:
                self._leave_out(name, companion, error, controls)
        return tuple(given)

    def add(self, reading: Reading, controls: Controls) -> None:
        """Show a reading to all of them."""
        for name, companion in self._each:
            try:
                companion.add(reading, controls)
            except Exception as error:
                self._leave_out(name, companion, error, controls)

    @property
    def need_pictures(self) -> bool:
        """Whether one of them does not let the camera rest."""
        return any(getattr(companion, "needs_pictures", False) for _, companion in self._each)

    def shown(self, controls: Controls) -> Mapping[str, object]:
        """Return what they show of themselves in this tick, by the features' names."""
        shown: dict[str, object] = {}
        for name, companion in self._each:
            try:
                if (own := getattr(companion, "shown", None)) is not None:
                    shown[name] = own
            except Exception as error:
                self._leave_out(name, companion, error, controls)
        return shown

    def close(self) -> None:
        """End all of them."""
        for _, companion in self._each:
            companion.close()

    def _leave_out(
        self, name: str, companion: Companion, error: Exception, controls: Controls
    ) -> None:
        LOG.exception("the feature %s failed", name)
        self._each = tuple(each for each in self._each if each[1] is not companion)
        with suppress(Exception):  # it is broken, and the robot drives
            companion.close()
        why = one_line(str(error)) or type(error).__name__
        words = phrase(f"The feature {name} no longer follows the drive: {why}.")
        controls.report(name, words)
