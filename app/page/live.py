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
from app.recordings.replay.opening import ReplayProgram


class Live:
    """All viewers of one program."""

    def __init__(self, program: Program, outlets: Outlets) -> None:
        self.program = program
        self.outlets = outlets
        self._writer = TelemetryWriter(program, outlets)
        self._written: tuple[Snapshot, str] | None = None

    def text(self, snapshot: Snapshot) -> str:
        """The telemetry of a snapshot as JSON; written once, however many viewers there are."""
        # Kept in one variable: other threads ask, too, perhaps for another snapshot.
        written = self._written
        if written is None or written[0] is not snapshot:
            text = self._writer.message(snapshot).model_dump_json()
            self._written = written = (snapshot, text)
        return written[1]

    async def serve(self, socket: WebSocket) -> None:
        """Talk to one viewer until it leaves; then nothing that it drove goes on."""
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
        self._outgoing = WebsocketWriter(socket)

    async def send_telemetry(self) -> None:
        """Send the newest snapshot whenever the last one has gone out."""
        with self._engine.latest.subscribe() as subscription:
            while await self._outgoing.send(self._live.text(await subscription.next())):
                pass

    async def take_commands(self) -> None:
        """Answer each command, until the viewer is gone."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            # A binary message has no text; an empty one is refused as no JSON.
            if not await self._outgoing.send(self._answer(message.get("text") or "")):
                return

    def _answer(self, text: str) -> str:
        try:
            command = parse(text)
            check(command, self._live.program)
            self._take(command)
        except ValueError as error:
            return ErrorMessage(id=_id_of(text), message=str(error)).model_dump_json()
        return AckMessage(id=command.id, stamp=self._robot_time()).model_dump_json()

    def _take(self, command: Command) -> None:
        """Hand a command to whom it concerns.

        Raises:
            ValueError: it cannot be carried out; says why.
        """
        outlets = self._live.outlets
        if isinstance(command, RecordCommand):
            outlets.record(command.on)
        elif isinstance(command, ReplayCommand):
            program = self._live.program
            assert isinstance(program, ReplayProgram)  # it was checked
            program.replay.asked.ask(
                command.paused, command.speed, command.position_s, command.step
            )
        elif not isinstance(command, PingCommand):
            self._engine.commands.put(command)
            outlets.drivers.took(self, command)

    def _robot_time(self) -> float | None:
        """The robot's clock now: the newest stamp and the time since it was published."""
        latest = self._engine.latest.get()
        return None if latest is None else latest.stamp + time.monotonic() - latest.published


def _id_of(text: str) -> int | str | None:
    """The id of a refused command, as far as it can be read."""
    try:
        content: Any = json.loads(text)
        result = content.get("id") if isinstance(content, dict) else None
        # Half a surrogate pair is valid JSON, but no text that could be sent back.
        str(result).encode()
    except (ValueError, RecursionError):
        return None
    return result if type(result) in (int, str) and len(str(result)) <= 200 else None
