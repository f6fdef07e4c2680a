"""``/api/live``: telemetry out, commands in."""

from __future__ import annotations

import json
import logging
import math
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import anyio
from anyio.abc import TaskGroup
from starlette.websockets import WebSocket

from app.engine.commands import parse, row_of
from app.engine.driver import Driver
from app.engine.mailboxes.slow_lane import SlowLane
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.feature_search import reason_of
from app.languages.marking import phrase
from app.messages.commands import (
    AckMessage,
    Command,
    ErrorMessage,
    SetParametersCommand,
)
from app.page.outlets import Outlets
from app.page.people import driver_of
from app.page.telemetry import TelemetryWriter
from app.page.token_guard import WHY, may_run_code, role_in
from app.page.tokens import Role
from robot.errors import BrickPoseError, CommandError

LOG = logging.getLogger("brickpose")

NOT_MINE = '"mine":false,"this_page":false'
MINE, HERE = '"mine":true,"this_page":false', '"mine":true,"this_page":true'
"""The only places where telemetry differs between viewers."""
LATEST_S = 0.5
"""A drive command that was sent longer ago [s] says nothing of what its sender wants now. With half
of it a page at the end of a slow network could not drive; with twice of it, what had waited for a
network that was gone for a second could end a stop."""
LATE = phrase("the command came too late to drive by it")
WATCHES = phrase("This link only watches; ask for the link to drive.")
NO_CODE = phrase(
    "A model of your own is Python: where a token is asked for, the page chooses none, unless "
    "brickpose is started with --allow-code."
)


class Live:
    """Serves all viewers of one program."""

    def __init__(self, program: Program, outlets: Outlets) -> None:
        self.program = program
        self.outlets = outlets
        self._writer = TelemetryWriter(program, outlets)
        self._written: _Written | None = None

    def text(self, snapshot: Snapshot, viewer: Driver | None = None) -> str:
        """Return the telemetry of a snapshot as JSON, for a viewer; it is written once for all."""
        # Read the attribute only once: another thread may replace it by another snapshot's.
        written = self._written
        if written is None or written.snapshot is not snapshot:
            driver = self.outlets.drivers.state.driver
            text = self._writer.message(snapshot).model_dump_json()
            self._written = written = _Written(snapshot, driver, text)
        driver = written.driver
        if viewer is None or driver is None or viewer.person != driver.person:
            return written.text
        return written.text.replace(NOT_MINE, HERE if viewer is driver else MINE, 1)

    async def serve(self, socket: WebSocket, rate: float = math.inf) -> None:
        """Serve one viewer until it leaves; then stop the robot if only this viewer drove it.

        ``rate`` is how many ticks a second it gets at most.
        """
        await socket.accept()
        viewer = _Viewer(self, socket, rate)
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(viewer.send_telemetry)
                await viewer.take_commands(tasks)
                tasks.cancel_scope.cancel()
        finally:
            self.outlets.drivers.leave(viewer.driver)


@dataclass(frozen=True, slots=True)
class _Written:
    """The telemetry of one snapshot, for all who do not drive."""

    snapshot: Snapshot
    driver: Driver | None
    text: str


class _Viewer:
    def __init__(self, live: Live, socket: WebSocket, rate: float) -> None:
        self._live = live
        self._rate = rate
        self._engine = live.program.engine
        self._socket = socket
        self._role = role_in(socket.scope)
        self._may_run_code = may_run_code(socket.scope)
        self.driver = driver_of(socket)
        self._outgoing = WebsocketWriter(socket)
        self._slow_lane = SlowLane()

    async def send_telemetry(self) -> None:
        """Send the newest snapshot as soon as the last one is sent."""
        engine, rate = self._engine, self._rate
        with engine.audience.joined(rate), engine.latest.subscribe(rate) as subscription:
            while await self._outgoing.send(
                self._live.text(await subscription.next(), self.driver)
            ):
                pass

    async def take_commands(self, tasks: TaskGroup) -> None:
        """Answer each command until the viewer is gone; slow ones when they are done."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            # A binary message has no text; an empty text is refused, as it is not JSON.
            text = message.get("text") or ""
            try:
                command = self._checked(text)
            except Exception as error:
                answer = _refused(_id_of(text), error)
            else:
                if row_of(command).slow:
                    answer_it = partial(self._answer, command)
                    await self._slow_lane.begin(tasks, answer_it, self._outgoing.send)
                    continue
                answer = self._answer(command)
            if not await self._outgoing.send(answer):
                return

    def _checked(self, text: str) -> Command:
        """Return the command in a text.

        Raises:
            BrickPoseError: it is none, or it is not allowed; the message says why.
        """
        command = parse(text)
        if self._role is Role.WATCH and not row_of(command).harmless:
            raise CommandError(self._socket.scope.get(WHY, WATCHES))
        if isinstance(command, SetParametersCommand) and not self._may_run_code:
            check_no_code(command)
        if row_of(command).drives and self._is_late(command.sent):
            raise CommandError(LATE)
        self._live.outlets.drivers.check(self.driver, command, self._live.program)
        # It is the same command whenever it was sent, also in a recording.
        return command if command.sent is None else command.model_copy(update={"sent": None})

    def _is_late(self, sent: float | None) -> bool:
        """Whether a command was sent [s] too long ago; not if it does not say when."""
        robot_time = self._robot_time()
        return sent is not None and robot_time is not None and robot_time - sent > LATEST_S

    def _answer(self, command: Command) -> str:
        try:
            self._live.outlets.carry_out(self.driver, command)
        except Exception as error:
            return _refused(command.id, error)
        return AckMessage(id=command.id, stamp=self._robot_time()).model_dump_json()

    def _robot_time(self) -> float | None:
        """Return the robot's clock now: the newest stamp plus the time since its publication."""
        latest = self._engine.latest.get()
        return None if latest is None else latest.stamp + time.monotonic() - latest.published


def check_no_code(command: SetParametersCommand) -> None:
    """Raise a CommandError if a change of parameters has a file of Python run."""
    if any(isinstance(value, str) and ":" in value for value in command.values.values()):
        raise CommandError(NO_CODE)


def _refused(command_id: int | str | None, error: Exception) -> str:
    """Answer with a refusal, or with what failed in the code that a feature has for the command."""
    words = str(error)
    if not isinstance(error, BrickPoseError):
        LOG.error("a command failed", exc_info=error)
        words = f"the command failed: {reason_of(error)}"
    return ErrorMessage(id=command_id, message=words).model_dump_json()


def _id_of(text: str) -> int | str | None:
    """Return the id of a refused command; None if it cannot be read."""
    try:
        content: Any = json.loads(text)
        result = content.get("id") if isinstance(content, dict) else None
        # Half a surrogate pair is valid JSON, but it cannot be encoded and sent back.
        str(result).encode()
    except (ValueError, RecursionError):
        return None
    return result if type(result) in (int, str) and len(str(result)) <= 200 else None
