"""Choices: planners and controllers by their names: ours, those of packages, those of files."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from app.engine.plugging import plugged
from app.features.navigation.own_code import OwnController, OwnPlanner
from robot.errors import CommandError
from robot.navigation.controllers import CONTROLLERS, ControllerKind, PathController
from robot.navigation.planners import PLANNERS, PlannerKind
from robot.navigation.settings import NavigationSettings


def planners() -> Mapping[str, PlannerKind]:
    """Return the planners by name: ours, and those of packages."""
    added = (kind for feature in plugged().features.active for make in feature.planners
             for kind in make())  # fmt: skip
    return {kind.name: kind for kind in added} | dict(PLANNERS)


def controllers() -> Mapping[str, ControllerKind]:
    """Return the controllers by name: ours, and those of packages."""
    added = (kind for feature in plugged().features.active for make in feature.controllers
             for kind in make())  # fmt: skip
    return {kind.name: kind for kind in added} | dict(CONTROLLERS)


class Choices:
    """What plans and what drives; files of one's own are read once, and again when saved."""

    def __init__(self, settings: NavigationSettings) -> None:
        """Choose by settings; nothing is read yet."""
        self._settings = settings
        self._own: dict[str, OwnPlanner | OwnController] = {}
        self._lock = threading.Lock()

    def require(self, planner: str | None, controller: str | None) -> None:
        """Refuse names that are none: ours, those of packages, and those in the settings are.

        Raises:
            CommandError: lists the valid ones.
        """
        for part, name, chosen, known in (
            ("planner", planner, self._settings.planner, planners()),
            ("controller", controller, self._settings.controller, controllers()),
        ):
            # A client may not name a file: whoever may drive need not be allowed to run code.
            wanted = chosen if name is None else name
            if wanted not in known and (wanted != chosen or ".py:" not in chosen):
                own = () if chosen in known else (chosen,)
                valid = ", ".join([*known, *own])
                raise CommandError(f"there is no {part} {wanted}; valid are {valid}")

    def planner(self, name: str | None) -> PlannerKind:
        """Return a planner by its name; None is that of the settings.

        Raises:
            SettingError: a file is not there.
        """
        wanted = name or self._settings.planner
        if kind := planners().get(wanted):
            return kind
        with self._lock:
            own = self._own.get(wanted)
            if not isinstance(own, OwnPlanner):
                own = self._own[wanted] = OwnPlanner(wanted)
        return PlannerKind(wanted, own.plan, OwnPlanner.PATIENCE_S)

    def controller(self, name: str | None) -> PathController:
        """Return a controller by its name; None is that of the settings.

        Raises:
            SettingError: a file is not there.
        """
        wanted = name or self._settings.controller
        if kind := controllers().get(wanted):
            return kind.make()
        with self._lock:
            own = self._own.get(wanted)
            if not isinstance(own, OwnController):
                own = self._own[wanted] = OwnController(wanted)
        return own
