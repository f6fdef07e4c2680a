"""Encodes messages for clients; each encoding is made once for all clients that want it."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable
from typing import Any

import cbor2
import cv2
import numpy as np

from app.ros2.rosbridge.values.writing import cbor_values, json_values
from app.ros2.topic import Published

SECOND_NS = 1_000_000_000


class Encoder:
    """Remembers the newest encoded message by name and compression; for one thread."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], tuple[Published, str | bytes]] = {}

    def encode(self, published: Published, name: str, compression: str) -> str | bytes:
        """Encode a message as a ``publish`` operation.

        Args:
            published: the message.
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
