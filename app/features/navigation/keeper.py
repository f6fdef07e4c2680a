"""JourneyKeeper: keeps a journey up as long as its sender is there, and refuses goals in walls."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from dataclasses import replace

from app.engine.command_row import Arbiter
from app.engine.driver import Driver
from app.engine.program import Program
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.features.navigation.walls import walls_in
from robot.errors import CommandError
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.navigation_status import NavigationStatus
from robot.navigation.planning import NoWayError, require_free
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import Walls
from robot.worker_thread import WorkerThread

RENEWALS = 4
"""A journey is renewed so often within the time that a drive command holds."""
BEGINS_S = 2.0
"""A tick shows a journey at the latest this long after its command [s]."""
RENEWAL = NavigateCommand(type="navigate")


class JourneyKeeper:
    """Renews the journey of a client that sends its goal only once."""

    def __init__(self, program: Program) -> None:
        """Prepare to keep journeys of a program up."""
        self._program = program
        self._settings: NavigationSettings = program.config.group(
            "navigation", NavigationSettings()
        )
        self._kept: tuple[Driver, Arbiter, float] | None = None
        self._lock = threading.Lock()
        self._space: tuple[Walls, FreeSpace] | None = None
        self._space_lock = threading.Lock()
        self._thread: WorkerThread | None = None

    def require_known(self, command: NavigateCommand) -> None:
        """Refuse a planner or a controller that there is not.

        Raises:
            CommandError: lists the valid ones.
        """
        from app.features.navigation.choices import Choices  # noqa: PLC0415 - the first goal

        Choices(self._settings).require(command.planner, command.controller)

    def require_free(self, goals: Iterable[GoalMessage]) -> None:
        """Refuse goals where the robot would touch a wall.

        Raises:
            CommandError: names the goal, and what is in the way.
        """
        for goal in goals:
            if goal.theta is None:
                continue
            pose, place = Pose2(goal.x, goal.y, goal.theta), f"({goal.x:.3f}, {goal.y:.3f}) m"
            try:
                require_free(self.space(), pose)
            except NoWayError as error:
                if self.walls.zones and self._free_of(replace(self.walls, zones=())).fits(
                    pose.to_array()[None]
                ):
                    raise CommandError(
                        f"at the goal the robot would touch a keep-out zone: {place}"
                    ) from error
                raise CommandError(f"{error}: {place}") from error

    def keep(self, driver: Driver | None, arbiter: Arbiter) -> None:
        """Renew the journey of a client from now on; None is one that renews it itself."""
        with self._lock:
            self._kept = None if driver is None else (driver, arbiter, time.monotonic())
            if driver is None or self._thread is not None:
                return
            self._thread = WorkerThread(
                "navigation", self._renew, owner="the journeys", patience=3.0
            )
            self._thread.start()

    def close(self) -> None:
        """End the thread."""
        if self._thread is not None:
            self._thread.stop()

    @property
    def walls(self) -> Walls:
        """What was said of walls, as the newest tick has it."""
        latest = self._program.engine.latest.get()
        return walls_in(latest.added if latest else {})

    @property
    def map_is_drawn(self) -> bool:
        """Whether a map is drawn by driving: the field's map then counts no more."""
        latest = self._program.engine.latest.get()
        return latest is not None and latest.drawn is not None

    @property
    def ignores_tape(self) -> bool:
        """Whether the robot may cross tape."""
        return self.walls.ignore_tape(self._program.field, self._settings)

    def space(self) -> FreeSpace:
        """Return the free space as it is now; several threads may ask."""
        walls = self.walls
        with self._space_lock:
            if self._space is None or self._space[0] != walls:
                self._space = walls, self._free_of(walls)
            return self._space[1]

    def _free_of(self, walls: Walls) -> FreeSpace:
        outline = self._program.engine.spec.outline
        return FreeSpace.of(self._program.field, outline, self._settings, walls)

    def _renew(self, stopping: threading.Event) -> None:
        period = self._program.config.drive.cmd_vel_timeout / RENEWALS
        while not stopping.wait(period):
            with self._lock:
                kept = self._kept
                if kept is not None and not self._renewed(*kept):
                    self._kept = None

    def _renewed(self, driver: Driver, arbiter: Arbiter, began: float) -> bool:
        """Renew a journey; False if it is over, or somebody else drives."""
        latest = self._program.engine.latest.get()
        status: NavigationStatus | None = latest.added.get("navigation") if latest else None
        over = status is None or not status.active or self.map_is_drawn
        if over and time.monotonic() - began > BEGINS_S:
            return False
        return arbiter.renew(driver, RENEWAL)
