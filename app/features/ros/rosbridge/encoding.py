"""Encodes messages for clients, each once for all that want it, as rosbridge_suite does."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import cbor2
import cv2
import numpy as np
from cbor2 import CBORTag

from app.features.ros.message_types import Message
from app.features.ros.rosbridge.names import NUMBERS, FieldType, fields
from app.features.ros.topics import Published

SECOND_NS = 1_000_000_000
Writer = Callable[[Any], Any]
BINARY = ("uint8", "char")
"""Arrays of these types are base64 in JSON, and a byte string in CBOR."""
TAGS = {
    "uint16": 69,
    "uint32": 70,
    "uint64": 71,
    "int8": 72,
    "int16": 77,
    "int32": 78,
    "int64": 79,
    "float32": 85,
    "float64": 86,
}
"""CBOR tags of typed arrays, little endian (RFC 8746, table 1)."""


class Encoder:
    """Remembers the newest encoded message by name and compression; for one thread."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], tuple[Published, str | bytes]] = {}

    def encode(self, published: Published, name: str, compression: str) -> str | bytes:
        """Encode a message as a ``publish`` operation.

        Args:
            name: the topic's name, as the client spells it.
            compression: one of COMPRESSIONS.
        """
        key = (name, compression)
        made = self._made.get(key)
        if made is None or made[0] is not published:
            made = self._made[key] = (published, COMPRESSIONS[compression](published, name))
        return made[1]


def _publish(name: str, values: dict[str, Any]) -> dict[str, Any]:
    return {"op": "publish", "topic": name, "msg": values}


def _json(published: Published, name: str) -> str:
    values = _publish(name, json_values(published.message))
    return json.dumps(values, separators=(",", ":"), allow_nan=False)


def _cbor(published: Published, name: str) -> bytes:
    return cbor2.dumps(_publish(name, cbor_values(published.message)))


def _cbor_raw(published: Published, name: str) -> bytes:
    secs, nsecs = divmod(published.log_time_ns, SECOND_NS)
    return cbor2.dumps(_publish(name, {"secs": secs, "nsecs": nsecs, "bytes": published.cdr}))


def _png(published: Published, name: str) -> str:
    return as_png(_json(published, name))


def as_png(text: str) -> str:
    """Make a ``png`` operation: the bytes of a text as the pixels of a picture, row by row.

    The picture is almost square. Line feeds fill its last row.
    """
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = math.ceil(len(data) / (3 * width))
    pixels = np.frombuffer(data.ljust(3 * width * height, b"\n"), np.uint8)
    red_green_blue = pixels.reshape(height, width, 3)
    _, picture = cv2.imencode(".png", red_green_blue[:, :, ::-1])
    return json.dumps({"op": "png", "data": base64.b64encode(picture.tobytes()).decode("ascii")})


COMPRESSIONS: dict[str, Callable[[Published, str], str | bytes]] = {
    "none": _json,
    "png": _png,
    "cbor": _cbor,
    "cbor-raw": _cbor_raw,
}
"""The compressions that a client may choose; the default is ``none``, which is JSON."""


def json_values(message: Message) -> dict[str, Any]:
    """Convert a message to JSON values: bytes to base64; NaN and infinity, not in JSON, to null."""
    return dict(_object_writer(message.__msgtype__, _json_field)(message))


def cbor_values(message: Message) -> dict[str, Any]:
    """Convert a message to CBOR values: arrays of numbers to typed arrays."""
    return dict(_object_writer(message.__msgtype__, _cbor_field)(message))


@cache
def _object_writer(type_name: str, of_field: Callable[[FieldType], Writer]) -> Writer:
    writers = [(name, of_field(kind)) for name, kind in fields(type_name).items()]
    return lambda message: {name: write(getattr(message, name)) for name, write in writers}


def _json_field(kind: FieldType) -> Writer:
    if kind.nested:
        return _nested(kind, _json_field)
    if kind.many:
        return _json_array(kind)
    return _json_float if kind.name.startswith("float") else _same


def _cbor_field(kind: FieldType) -> Writer:
    if kind.nested:
        return _nested(kind, _cbor_field)
    return _cbor_array(kind) if kind.many else _same


def _nested(kind: FieldType, of_field: Callable[[FieldType], Writer]) -> Writer:
    write = _object_writer(kind.name, of_field)
    return (lambda many: [write(item) for item in many]) if kind.many else write


def _json_array(kind: FieldType) -> Writer:
    if kind.name in BINARY:
        return lambda many: base64.b64encode(many.tobytes()).decode("ascii")
    if kind.name.startswith("float"):
        return _json_floats
    return (lambda many: many.tolist()) if kind.name in NUMBERS else list


def _cbor_array(kind: FieldType) -> Writer:
    if kind.name in BINARY:
        return lambda many: many.tobytes()
    tag = TAGS.get(kind.name)
    if tag is None:
        return _json_array(kind)
    little = NUMBERS[kind.name].newbyteorder("<")
    return lambda many: CBORTag(tag, many.astype(little).tobytes())


def _same(value: Any) -> Any:
    return value


def _json_float(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _json_floats(values: np.ndarray) -> list[float | None]:
    listed: list[float | None] = values.tolist()
    if np.isfinite(values).all():
        return listed
    return [_json_float(item) for item in listed]  # type: ignore[arg-type]
