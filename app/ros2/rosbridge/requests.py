"""Parses what a client sends: JSON, possibly in fragments."""

from __future__ import annotations

import json
from typing import Any

from app.ros2.message_types import MessageError
from app.ros2.rosbridge.reading import shown

LONGEST = 200_000
"""Longest message [characters]; messages to a robot are shorter."""

LONGEST_NAME = 200
"""Longest topic, type and id [characters]; answers repeat them."""

MOST_PIECES = 1000
MOST_OPEN = 10
"""Most messages that a client may send in fragments at the same time."""

Request = dict[str, Any]


def parse(data: str | bytes) -> Request:
    """Return the operation in a message.

    Raises:
        MessageError: the message is not an operation; says what is valid.
    """
    if len(data) > LONGEST:
        raise MessageError(f"a message has at most {LONGEST} bytes; this has {len(data)}")
    try:
        text = data if isinstance(data, str) else data.decode()
        request = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MessageError(f"no JSON: {str(error)[:100]}") from None
    if not isinstance(request, dict) or not isinstance(request.get("op"), str):
        raise MessageError('valid is an object with "op", as {"op": "subscribe", ...}')
    return request


def text(request: Request, name: str) -> str:
    """Return a required text field.

    Raises:
        MessageError: it is missing, too long, or not a printable text.
    """
    value = request.get(name)
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST_NAME or not value.isprintable():
        raise MessageError(f"{name} is {shown(value)}; valid is a text of 1 to {LONGEST_NAME}")
    return value


def maybe_text(request: Request, name: str) -> str | None:
    """Return a text field that may be missing or empty; then it is None."""
    return text(request, name) if request.get(name) else None


def request_id(request: Request) -> str | int | None:
    """Return the id if it can be repeated in an answer, else None."""
    result = request.get("id")
    if isinstance(result, str):
        return result if len(result) <= LONGEST_NAME and result.isprintable() else None
    return result if type(result) is int and result.bit_length() <= 64 else None


class Pieces:
    """Assembles messages that come as ``fragment`` operations."""

    def __init__(self) -> None:
        self._open: dict[str | int, dict[int, str]] = {}

    def add(self, request: Request) -> str | None:
        """Add a fragment; return the whole message once all are there, else None.

        Raises:
            MessageError: it is not a fragment, or its message is too long.
        """
        name, number, total = request_id(request), request.get("num"), request.get("total")
        data = request.get("data")
        if name is None or not isinstance(data, str):
            raise MessageError("a fragment needs id, num, total and data")
        if type(number) is not int or type(total) is not int:
            raise MessageError("a fragment's num and total are whole numbers")
        if not 0 <= number < total <= MOST_PIECES:
            raise MessageError(
                f"fragment {shown(number)} of {shown(total)}; valid are 0 to total - 1 of at most "
                f"{MOST_PIECES}"
            )
        return self._put(name, number, total, data)

    def _put(self, name: str | int, number: int, total: int, data: str) -> str | None:
        if name not in self._open and len(self._open) >= MOST_OPEN:
            del self._open[next(iter(self._open))]  # the oldest: its other fragments were lost
        pieces = self._open.setdefault(name, {})
        pieces[number] = data
        if sum(map(len, pieces.values())) > LONGEST:
            del self._open[name]
            raise MessageError(f"a message has at most {LONGEST} bytes, in all its fragments")
        if len(pieces) < total:
            return None
        del self._open[name]
        return "".join(pieces[place] for place in sorted(pieces))
