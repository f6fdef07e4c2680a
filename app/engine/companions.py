"""Companions of an engine: what features do in each tick."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Protocol

from app.engine.controls import Controls
from app.engine.problems import LOG, failing_alone
from app.feature_search import reason_of
from app.languages.marking import phrase
from app.messages.commands import Command
from app.settings.config import Config
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
        self._given: list[tuple[Command, str, Companion]] = []
        """This tick's commands, and whose they are."""

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> tuple[Command, ...]:
        """Return the commands of all of them."""
        for name, failure in self._failures.items():
            controls.report(name, failure)
        self._failures = {}
        self._given = []
        for name, companion in self._each:
            try:
                given = tuple(companion.commands(odom_from_robot, controls))
                for command in given:
                    if not isinstance(command, Command):
                        raise TypeError(f"it commands {command!r}; valid is a CommandMessage")
                self._given += ((command, name, companion) for command in given)
            except Exception as error:
                self._leave_out(name, companion, error, controls)
        return tuple(command for command, _, _ in self._given)

    def leave_out_giver(self, command: Command, error: Exception, controls: Controls) -> bool:
        """Leave out who gave a command that failed; return whether it was one of them."""
        givers = [(name, giver) for given, name, giver in self._given if given is command]
        for name, giver in givers:
            self._leave_out(name, giver, error, controls)
        return bool(givers)

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
        """Return what they show in this tick, by the features' names, and what commands keep."""
        shown = controls.kept.copy()
        for name, companion in self._each:
            try:
                if (own := getattr(companion, "shown", None)) is not None:
                    shown[name] = own
            except Exception as error:
                self._leave_out(name, companion, error, controls)
        return shown

    def close(self) -> None:
        """End all of them, whatever one of them raises."""
        for name, companion in self._each:
            with failing_alone(name):
                companion.close()

    def _leave_out(
        self, name: str, companion: Companion, error: Exception, controls: Controls
    ) -> None:
        LOG.error("the feature %s failed", name, exc_info=error)
        self._each = tuple(each for each in self._each if each[1] is not companion)
        with failing_alone(name):  # it is broken, and the robot drives
            companion.close()
        why = reason_of(error)
        words = phrase(f"The feature {name} no longer follows the drive: {why}.")
        controls.report(name, words)
