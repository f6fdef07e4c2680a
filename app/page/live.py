"""``/api/live``: telemetry out, commands in."""

from __future__ import annotations

import json
import time
from typing import Any

import anyio
from starlette.websockets import WebSocket

from app.engine.commands import check
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.messages.commands import (
    AckMessage,
    Command,
    ErrorMessage,
    PingCommand,
    RecordCommand,
    ReplayCommand,
)
from app.messages.parsing import parse
from app.page.outlets import Outlets
from app.page.telemetry import TelemetryWriter
from app.page.token_guard import role_in
from app.page.tokens import Role
from app.recordings.replay.opening import ReplayProgram
from robot.errors import BrickPoseError

WATCHES = "This link only watches; ask for the link to drive."
"""Answer to commands of a viewer who only watches."""


class Live:
    """Serves all viewers of one program."""

    def __init__(self, program: Program, outlets: Outlets) -> None:
        self.program = program
        self.outlets = outlets
        self._writer = TelemetryWriter(program, outlets)
        self._written: tuple[Snapshot, str] | None = None

    def text(self, snapshot: Snapshot) -> str:
        """Return the telemetry of a snapshot as JSON; it is written once for all viewers."""
        # Read the attribute only once: another thread may replace it by another snapshot's.
        written = self._written
        if written is None or written[0] is not snapshot:
            text = self._writer.message(snapshot).model_dump_json()
            self._written = written = (snapshot, text)
        return written[1]

    async def serve(self, socket: WebSocket) -> None:
        """Serve one viewer until it leaves; then stop the robot if only this viewer drove it."""
        await socket.accept()
        viewer = _Viewer(self, socket)
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(viewer.send_telemetry)
                await viewer.take_commands()
                tasks.cancel_scope.cancel()
        finally:
            self.outlets.drivers.leave(viewer)


class _Viewer:
    def __init__(self, live: Live, socket: WebSocket) -> None:
        self._live = live
        self._engine = live.program.engine
        self._socket = socket
        self._role = role_in(socket.scope)
        self._outgoing = WebsocketWriter(socket)

    async def send_telemetry(self) -> None:
        """Send the newest snapshot as soon as the last one is sent."""
        with self._engine.latest.subscribe() as subscription:
            while await self._outgoing.send(self._live.text(await subscription.next())):
                pass

    async def take_commands(self) -> None:
        """Answer each command until the viewer is gone."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            # A binary message has no text; an empty text is refused, as it is not JSON.
            if not await self._outgoing.send(self._answer(message.get("text") or "")):
                return

    def _answer(self, text: str) -> str:
        try:
            command = parse(text)
            if self._role is Role.WATCH and not isinstance(command, PingCommand):
                raise ValueError(WATCHES)
            check(command, self._live.program)
            self._take(command)
        except BrickPoseError as error:
            return ErrorMessage(id=_id_of(text), message=str(error)).model_dump_json()
        return AckMessage(id=command.id, stamp=self._robot_time()).model_dump_json()

    def _take(self, command: Command) -> None:
        """Pass a command to recorder, replay or engine.

        Raises:
            BrickPoseError: the command cannot be carried out; the message says why.
        """
        outlets = self._live.outlets
        if isinstance(command, RecordCommand):
            outlets.record(command.on)
        elif isinstance(command, ReplayCommand):
            program = self._live.program
            assert isinstance(program, ReplayProgram)  # ``check`` made sure of it
            program.replay.asked.ask(
                command.paused, command.speed, command.position_s, command.step
            )
        elif not isinstance(command, PingCommand):
            self._engine.commands.put(command)
            outlets.drivers.took(self, command)

    def _robot_time(self) -> float | None:
        """Return the robot's clock now: the newest stamp plus the time since its publication."""
        latest = self._engine.latest.get()
        return None if latest is None else latest.stamp + time.monotonic() - latest.published


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
