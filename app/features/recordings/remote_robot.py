"""A remote robot, on another machine or in another program, reached by its rosbridge.

It sends messages in CBOR; answers and complaints in JSON.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any
from urllib.error import HTTPError
from urllib.parse import parse_qs, urlsplit
from urllib.request import Request, urlopen

import cbor2
from websockets.exceptions import InvalidHandshake, WebSocketException
from websockets.sync.client import ClientConnection, connect

from app.features.recordings.attachments import Contents
from app.features.recordings.routes import ContentsMessage
from app.features.ros.message_types import MessageError
from robot.errors import BrickPoseError
from robot.settings import SettingError

NO_MESSAGE = (
    cbor2.CBORError, EOFError, RecursionError, ArithmeticError, ValueError, LookupError, TypeError,
    AttributeError,
)  # fmt: skip
"""Exceptions that decoding arbitrary data may raise."""
ANSWER_S = 10.0
CLOSE_S = 1.0
"""How long to wait for the robot's end of the connection [s]; a busy robot may answer late."""
LARGEST = 64_000_000
"""Largest message [bytes]; those of topics are smaller."""
QUEUE = 10_000
"""Most messages that may wait at the robot while this program is slow."""


@dataclass(frozen=True, slots=True)
class Received:
    """One received message."""

    topic: str
    log_time_ns: int
    cdr: bytes


def parse_received(data: str | bytes) -> Received | None:
    """Return the message in CBOR; None for a text that is no complaint.

    Raises:
        MessageError: the data are not a message, or the robot complains; says why.
    """
    try:
        if isinstance(data, bytes):
            return _message(data)
        _check_complaint(data)
    except NO_MESSAGE as error:
        raise MessageError(str(error) or type(error).__name__) from error
    return None


def _check_complaint(text: str) -> None:
    given = json.loads(text)
    if given.get("op") == "status":
        raise ValueError(str(given.get("msg"))[:300])


def _message(data: bytes) -> Received:
    given = cbor2.loads(data)
    message: Any = given["msg"]
    stamp = int(message["secs"]) * 1_000_000_000 + int(message["nsecs"])
    if not 0 <= stamp < 1 << 63:
        raise ValueError(f"{stamp} ns is no time")
    # A number would be taken for the length of so many zeros.
    if not isinstance(message["bytes"], bytes):
        raise TypeError("its content is no bytes")
    return Received(str(given["topic"]), stamp, message["bytes"])


class RemoteRobotError(BrickPoseError, RuntimeError):
    """The robot does not answer as rosbridge does, or not at all; says why."""


class RemoteRobot:
    """A connection to ``/rosbridge``; one thread."""

    def __init__(self, address: str) -> None:
        """Connect.

        Args:
            address: ``host``, ``host:port``, or a whole URL of http or ws, such as the link that
                the robot prints; if the link has no token, the one in ``BRICKPOSE_TOKEN`` is used.

        Raises:
            SettingError: the address is invalid.
            RemoteRobotError: no rosbridge answers there.
        """
        self.place = host_and_port(address)
        self._headers = _authorization(address)
        try:
            self._socket: ClientConnection = connect(
                f"ws://{self.place}/rosbridge",
                open_timeout=ANSWER_S,
                close_timeout=CLOSE_S,
                max_size=LARGEST,
                additional_headers=self._headers,
            )
        except (OSError, ValueError, InvalidHandshake, WebSocketException) as error:
            raise RemoteRobotError(
                f"no program can be recorded at {self.place}: {error}; valid is the address that "
                "`brickpose run` tells, as robot.local:8080"
            ) from error

    def topics(self) -> dict[str, str]:
        """Return the type of each topic by its name.

        Raises:
            RemoteRobotError: there is no valid answer.
        """
        request = {"op": "call_service", "service": "/rosapi/topics", "id": "topics"}
        self._socket.send(json.dumps(request))
        try:
            values = self._answer("topics")
            return dict(zip(values["topics"], values["types"], strict=True))
        except (*NO_MESSAGE, TimeoutError, WebSocketException) as error:
            raise RemoteRobotError(f"{self.place} does not tell its topics: {error}") from error

    def contents(self) -> Contents:
        """Return the facts and files for its recordings.

        They are empty if the robot does not serve them: only BrickPose does.

        Raises:
            RemoteRobotError: the answer is invalid, or the robot could not give one.
        """
        url = f"http://{self.place}/api/recording_contents"
        try:
            with urlopen(Request(url, headers=self._headers), timeout=ANSWER_S) as answer:
                given = answer.read(LARGEST)
            return ContentsMessage.model_validate_json(given).contents()
        except HTTPError as error:
            if error.code < HTTPStatus.INTERNAL_SERVER_ERROR:
                return Contents({})  # another program, which only speaks rosbridge
            raise RemoteRobotError(f"{self.place} does not tell its settings: {error}") from error
        except (OSError, ValueError) as error:
            raise RemoteRobotError(f"{self.place} does not tell its settings: {error}") from error

    def follow(self, topic: str, type_name: str, period: float) -> None:
        """Ask for all messages of a topic, at most one per period [s]."""
        self._socket.send(
            json.dumps(
                {
                    "op": "subscribe",
                    "id": f"record {topic}",
                    "topic": topic,
                    "type": type_name,
                    "compression": "cbor-raw",
                    "queue_length": QUEUE,
                    "throttle_rate": round(1000 * period),
                    "every": True,  # an addition of BrickPose, unknown to others
                }
            )
        )

    def receive(self, timeout: float) -> Received | None:
        """Return the next message; None if none comes within the timeout [s].

        Raises:
            RemoteRobotError: the connection is lost, or the data are not a message.
        """
        try:
            data = self._socket.recv(timeout=timeout)
        except TimeoutError:
            return None
        except WebSocketException as error:
            raise RemoteRobotError(f"the connection to {self.place} was lost: {error}") from error
        try:
            return parse_received(data)
        except MessageError as error:
            raise RemoteRobotError(f"{self.place} sent what is no message: {error}") from error

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _answer(self, request_id: str) -> dict[str, Any]:
        for message in self._texts():
            if message.get("id") == request_id and message.get("op") == "service_response":
                if not message["result"]:
                    raise ValueError(str(message["values"]))
                return dict(message["values"])
        raise ValueError("no answer")

    def _texts(self) -> Iterator[dict[str, Any]]:
        for _ in range(100):
            yield dict(json.loads(self._socket.recv(timeout=ANSWER_S)))


def _authorization(address: str) -> dict[str, str]:
    """Return the header that a robot with tokens asks for; none if no token is known."""
    given = parse_qs(urlsplit(address).query).get("token", [])
    token = given[0] if given else os.environ.get("BRICKPOSE_TOKEN")
    return {"Authorization": f"Bearer {token}"} if token else {}


def host_and_port(address: str) -> str:
    """Return host and port of an address; without a port, it is 8080.

    Raises:
        SettingError: the address is invalid.
    """
    whole = address if "//" in address else f"//{address}"
    try:
        parts = urlsplit(whole)
        host, port = parts.hostname, parts.port or 8080
    except ValueError:
        host, port = None, 0
    if not host:
        raise SettingError(f"{address!r} is no address; valid is HOST or HOST:PORT")
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
