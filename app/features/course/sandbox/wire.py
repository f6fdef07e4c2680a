"""The wire between the grader and a student's process, a pipe: JSON, with arrays as base64.

Nothing that is read is ever executed, as a pickle would be.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from robot.errors import BrickPoseError

LONGEST = 16 * 1024 * 1024
"""Longer messages are refused [bytes]."""
LENGTH = struct.Struct("<I")
DEEPEST = 6
"""Values are nested no deeper than this."""
WIRE_ERRORS = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError,
               MemoryError)  # fmt: skip
"""What reading may raise: who sends chooses each type, number and shape."""


class WireError(BrickPoseError, ValueError):
    """A message is not one of ours."""


def pack(message: Mapping[str, Any]) -> bytes:
    """Return a message with its length before it."""
    body = json.dumps({key: encode(value) for key, value in message.items()}).encode()
    return LENGTH.pack(len(body)) + body


def unpack(body: bytes) -> dict[str, Any]:
    """Return the message of a body.

    Raises:
        WireError: the body holds something else.
    """
    try:
        parsed = json.loads(body)
        return {str(key): decode(value) for key, value in dict(parsed).items()}
    except WIRE_ERRORS as error:
        raise WireError(f"not a message: {error}") from error


def encode(value: Any) -> Any:
    """Return a value as JSON has it; arrays, tuples and namespaces are marked."""
    if isinstance(value, np.ndarray):
        data = np.ascontiguousarray(value)
        content = base64.b64encode(data.tobytes()).decode()
        return {"array": content, "shape": list(data.shape), "type": data.dtype.str}
    if isinstance(value, SimpleNamespace):
        return {"names": {key: encode(item) for key, item in vars(value).items()}}
    if isinstance(value, list | tuple):
        return {"parts": [encode(item) for item in value]}
    if isinstance(value, np.generic):
        return value.item()
    return value


def decode(value: Any, depth: int = 0) -> Any:
    """Return what ``encode`` was given; parts become a tuple."""
    if depth > DEEPEST:
        raise WireError("nested too deeply")
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return _array(value)
    if "parts" in value:
        return tuple(decode(item, depth + 1) for item in value["parts"])
    if "names" in value:
        named = dict(value["names"])
        return SimpleNamespace(**{key: decode(item, depth + 1) for key, item in named.items()})
    return {str(key): decode(item, depth + 1) for key, item in value.items()}


def _array(value: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    if value["type"] not in ("<f8", "<i8", "|b1"):
        raise WireError(f"an array of {value['type']!r}")
    data = np.frombuffer(base64.b64decode(value["array"]), dtype=value["type"])
    return data.reshape([int(size) for size in value["shape"]]).copy()
