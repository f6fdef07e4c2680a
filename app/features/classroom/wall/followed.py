"""FollowedServer: one student's running server, as the wall sees it and orders it."""

from __future__ import annotations

import json
import math
import time
from dataclasses import dataclass, field
from http.client import HTTPException
from typing import Any
from urllib.error import HTTPError
from urllib.request import ProxyHandler, Request, build_opener

import anyio
import anyio.to_thread
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from app.features.classroom.class_desk import ADDRESS as DESK
from app.languages.marking import phrase

RATE_HZ = 2
"""Telemetry of each student a second: thirty of them are sixty messages, a tenth of a core."""
ANSWER_S = 5.0
SELDOM_S = 10.0
"""A server that sleeps is asked so seldom [s]: when it wakes, its telemetry says so. Asked each
second, it would cost a third of what sleeping costs."""
TAKEN_S = 120.0
"""A recording or a field that is handed out is read by each server first, thirty at once [s]."""
LONGEST_WORDS = 2000
AGAIN_S = 1.0
NOT_THERE = phrase("the robot is not there")
NO_ANSWER = phrase("the robot has not answered yet")
OPENER = build_opener(ProxyHandler({}))  # the students' servers are near


class _Ask:
    """A command that waits for its answer."""

    def __init__(self) -> None:
        self.heard = anyio.Event()
        self.refusal = NO_ANSWER

    def hear(self, refusal: str) -> None:
        self.refusal = refusal
        self.heard.set()


@dataclass
class FollowedServer:
    """A student's server; its newest telemetry comes by one socket, which also takes orders."""

    address: str
    """``http://HOST:PORT/user/ada/``."""
    token: str
    telemetry: dict[str, Any] = field(default_factory=dict)
    desk: dict[str, Any] = field(default_factory=dict)
    progress: dict[str, Any] = field(default_factory=dict)
    """Numbers of the lesson at hand, and of those that were begun and have passed."""
    field_name: str = ""
    foreign: bool = False
    """Whether it is another program, as JupyterLab: there is no robot to follow, nor to order."""
    area: dict[str, Any] = field(default_factory=dict)
    """``/api/field`` of the newest field."""
    _socket: ClientConnection | None = None
    _asks: dict[int, _Ask] = field(default_factory=dict)
    """Commands that wait for their answer, by number."""
    _number: int = 0
    _slept: dict[str, Any] = field(default_factory=dict)
    """The telemetry with which it was asleep, when it was asked last."""
    _asked: float = -math.inf

    @property
    def headers(self) -> dict[str, str]:
        """What the wall shows of itself."""
        return {"Authorization": f"token {self.token}"}

    async def follow(self) -> None:
        """Keep the newest telemetry, until cancelled; a server that went away is asked again."""
        place = f"{self.address.replace('http', 'ws', 1)}api/live?rate={RATE_HZ}"
        if await self._is_foreign():
            return
        while True:
            try:
                async with connect(
                    place, additional_headers=self.headers, max_size=None, proxy=None
                ) as socket:
                    self._socket = socket
                    async for text in socket:
                        message = json.loads(text)
                        if message["type"] == "telemetry":
                            self.telemetry = message
                        elif message.get("id") in self._asks:
                            self._asks[message["id"]].hear(message.get("message", ""))
            except (OSError, WebSocketException, ValueError):
                pass
            finally:
                self._socket, self.telemetry = None, {}
                for ask in self._asks.values():
                    ask.hear("")  # another field is loaded by another program
            await anyio.sleep(AGAIN_S)

    async def _is_foreign(self) -> bool:
        """Ask for the desk, which no other program has; once, as each request is a use."""

        def status() -> int:
            try:
                asked = Request(f"{self.address}{DESK}", None, self.headers)
                OPENER.open(asked, timeout=ANSWER_S).close()
            except HTTPError as error:
                with error:
                    return error.code
            except (OSError, HTTPException):
                return 0
            return 200

        self.foreign = await anyio.to_thread.run_sync(status) == 404
        return self.foreign

    async def look(self) -> None:
        """Read what the desk has, and the field if it is another one; seldom while it sleeps."""
        if self.foreign:
            return
        stamp = time.monotonic()
        still = self.desk.get("asleep") and self.telemetry is self._slept
        if still and stamp - self._asked < SELDOM_S:
            return
        self._slept, self._asked = self.telemetry, stamp
        self.desk = await self.ask(DESK) or {}
        self.progress = await self.ask("api/progress") or {}
        name = str(self.telemetry.get("map", ""))
        if name and name != self.field_name:
            self.area = await self.ask("api/field") or {}
            self.field_name = name if self.area else ""

    async def send(self, patience_s: float = ANSWER_S, **command: Any) -> str:
        """Send a command of the live socket; return why it was refused, or nothing."""
        if self._socket is None:
            return NOT_THERE
        self._number += 1
        number, ask = self._number, _Ask()
        self._asks[number] = ask
        try:
            await self._socket.send(json.dumps(command | {"id": number}))
            with anyio.move_on_after(patience_s):
                await ask.heard.wait()
        except WebSocketException:
            return NOT_THERE
        finally:
            del self._asks[number]
        return ask.refusal

    async def order(self, **order: Any) -> bool:
        """Give an order to the student's desk; return whether it was taken."""
        answer = await self.ask(DESK, order)
        self.desk = answer or self.desk
        return answer is not None

    async def ask(self, path: str, body: dict[str, Any] | None = None) -> Any:
        """Return the JSON that the server has at a path; None if it has none."""
        content = await self.read(path, body)
        try:
            return None if content is None else json.loads(content)
        except ValueError:
            return None

    async def read(self, path: str, body: dict[str, Any] | None = None) -> bytes | None:
        """Return what the server has at a path; None if it has nothing."""
        data = None if body is None else json.dumps(body).encode()
        headers = {**self.headers, "Content-Type": "application/json"}
        return await self._fetched(Request(self.address + path, data, headers))

    async def put(self, path: str, content: bytes) -> str:
        """Put something to a path of the server; return why it was not taken, or nothing."""
        # By default urllib says that it is a form, and the hub's proxy refuses one that is none.
        headers = {**self.headers, "Content-Type": "application/octet-stream"}
        request = Request(self.address + path, content, headers, method="PUT")

        def why_not() -> str:
            try:
                OPENER.open(request, timeout=TAKEN_S).close()
            except HTTPError as error:
                with error:
                    return _words(error.read(LONGEST_WORDS)) or f"HTTP {error.code}"
            except (OSError, HTTPException) as error:
                return str(error)
            return ""

        return await anyio.to_thread.run_sync(why_not)

    def opened(self, path: str) -> Any:
        """Return what the server has at a path, to be read bit by bit in a thread of one's own.

        Raises:
            OSError: it has nothing.
        """
        return OPENER.open(Request(self.address + path, None, self.headers), timeout=TAKEN_S)

    async def _fetched(self, request: Request) -> bytes | None:

        def fetched() -> bytes | None:
            try:
                with OPENER.open(request, timeout=ANSWER_S) as answer:
                    content: bytes = answer.read()
                    return content
            except (OSError, HTTPException):  # the latter: cut off within an answer
                return None

        return await anyio.to_thread.run_sync(fetched)


def _words(answer: bytes) -> str:
    """Return what a server's refusal says."""
    try:
        return str(json.loads(answer)["detail"])
    except (ValueError, KeyError, TypeError):
        return answer.decode("utf-8", "replace").strip()
