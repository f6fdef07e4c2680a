"""Reads what a robot's rosbridge sends to a recorder: messages in CBOR, and complaints in JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import cbor2

from app.ros2.message_types import MessageError

NO_MESSAGE = (
    cbor2.CBORError, EOFError, RecursionError, ArithmeticError, ValueError, LookupError, TypeError,
    AttributeError,
)  # fmt: skip
"""Exceptions that decoding arbitrary data may raise."""


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
