"""What a message looks like on its way to clients; made once for all that want it alike."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable
from typing import Any

import cbor2
import cv2
import numpy as np

from app.ros2.published import Published
from app.ros2.rosbridge.values.writing import cbor_values, json_values

SECOND_NS = 1_000_000_000


class Encoder:
    """Remembers the newest of each kind; for one thread."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], tuple[Published, str | bytes]] = {}

    def encode(self, published: Published, name: str, compression: str) -> str | bytes:
        """A ``publish`` operation.

        Args:
            published: the message.
            name: of the topic, as the client spells it.
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
    """A ``png`` operation: the bytes of a text as the pixels of a picture, row by row.

    The picture is as good as square, and line ends fill its last row.
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
"""What a client may ask for; without asking it gets ``none``, which is JSON."""
