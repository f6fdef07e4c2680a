"""``/api/live``: telemetry out, commands in."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import anyio
from anyio.abc import TaskGroup
from starlette.websockets import WebSocket

from app.engine.commands import RULES, check
from app.engine.drivers import Driver
from app.engine.mailboxes.slow_lane import SlowLane
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.languages.marking import phrase
from app.messages.commands import (
    AckMessage,
    Command,
    ErrorMessage,
    PingCommand,
    ReplayCommand,
    parse,
)
from app.page.outlets import Outlets
from app.page.telemetry import TelemetryWriter
from app.page.token_guard import role_in
from app.page.tokens import Role
from app.recordings.replay.opening import ReplayProgram
from robot.errors import BrickPoseError, CommandError

NOT_MINE, MINE = '"mine":false', '"mine":true'
"""The only places where telemetry differs between viewers."""
WATCHES = phrase("This link only watches; ask for the link to drive.")
"""Answer to commands of a viewer who only watches."""


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
        if viewer is None or viewer is not written.driver:
            return written.text
        return written.text.replace(NOT_MINE, MINE, 1)

    async def serve(self, socket: WebSocket) -> None:
        """Serve one viewer until it leaves; then stop the robot if only this viewer drove it."""
        await socket.accept()
        viewer = _Viewer(self, socket)
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
    def __init__(self, live: Live, socket: WebSocket) -> None:
        self._live = live
        self._engine = live.program.engine
        self._socket = socket
        self._role = role_in(socket.scope)
        self.driver = Driver.numbered(phrase("page {number}"), socket.client and socket.client.host)
        self._outgoing = WebsocketWriter(socket)
        self._slow_lane = SlowLane()

    async def send_telemetry(self) -> None:
        """Send the newest snapshot as soon as the last one is sent."""
        with self._engine.latest.subscribe() as subscription:
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
            except BrickPoseError as error:
                answer = _refused(_id_of(text), error)
            else:
                if RULES[type(command)].slow:
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
        if self._role is Role.WATCH and not isinstance(command, PingCommand):
            raise CommandError(WATCHES)
        check(command, self._live.program)
        return command

    def _answer(self, command: Command) -> str:
        try:
            self._carry_out(command)
        except BrickPoseError as error:
            return _refused(command.id, error)
        return AckMessage(id=command.id, stamp=self._robot_time()).model_dump_json()

    def _carry_out(self, command: Command) -> None:
        """Pass a command to replay, outlets or engine.

        Raises:
            BrickPoseError: the command cannot be carried out; the message says why.
        """
        if isinstance(command, ReplayCommand):
            program = self._live.program
            assert isinstance(program, ReplayProgram)  # ``check`` made sure of it
            program.replay.asked.ask(
                command.paused, command.speed, command.position_s, command.step
            )
        elif not isinstance(command, PingCommand):
            self._live.outlets.carry_out(self.driver, command)

    def _robot_time(self) -> float | None:
        """Return the robot's clock now: the newest stamp plus the time since its publication."""
        latest = self._engine.latest.get()
        return None if latest is None else latest.stamp + time.monotonic() - latest.published


def _refused(command_id: int | str | None, error: BrickPoseError) -> str:
    return ErrorMessage(id=command_id, message=str(error)).model_dump_json()


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
