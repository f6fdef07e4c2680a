"""Converts JSON values to messages; reports values that do not fit the type."""

from __future__ import annotations

import base64
import binascii
import dataclasses
import math
from typing import Any

import numpy as np

from app.features.ros.message_types import Message, MessageError, message_class
from app.features.ros.rosbridge.encoding import BINARY
from app.features.ros.rosbridge.names import FILLER, NUMBERS, FieldType, fields

QUATERNION = "geometry_msgs/msg/Quaternion"

TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")

OTHER_TIMES = {"secs": "sec", "nsecs": "nanosec", "nsec": "nanosec"}
"""Names of a time's fields in ROS 1 and in C++, with those in ROS 2, for pages that have them."""
HEADER = "std_msgs/msg/Header"
SEQUENCE = "seq"
"""ROS 1 counts messages in the header; ROS 2 has no such field."""


def message_of(values: Any, type_name: str, path: str = "") -> Message:
    """Make a message from a dict; missing fields get their defaults, as in ROS 2.

    Args:
        values: a value from JSON: dict, list, str, number, bool or None.
        type_name: such as ``geometry_msgs/msg/Twist``.
        path: path of the field that contains it, for error messages.

    Raises:
        MessageError: a field is unknown or does not fit; says which, and what is valid.
    """
    known = fields(type_name)
    if not isinstance(values, dict):
        raise _wrong(path, values, f"an object with {', '.join(known) or 'nothing in it'}")
    if type_name in TIMES:
        values = {OTHER_TIMES.get(name, name): value for name, value in values.items()}
    elif type_name == HEADER:
        values = {name: value for name, value in values.items() if name != SEQUENCE}
    for name in values:
        if name not in known:
            valid = ", ".join(known) or "none"
            raise MessageError(
                f"{_place(path, name)} is no field of {type_name}; valid are {valid}"
            )
    read = {
        name: _read(values[name], kind, _place(path, name)) if name in values else default(kind)
        for name, kind in known.items()
    }
    return _made(type_name, read, "w" in values)


def default(kind: FieldType) -> Any:
    """Return the default of a field: zeros, an empty text, an empty list, no rotation."""
    if kind.nested:
        empty = {name: default(inner) for name, inner in fields(kind.name).items()}
        item = _made(kind.name, empty, False)
        return [item for _ in range(kind.length)] if kind.many else item
    if not kind.many:
        return NUMBERS[kind.name].type(0).item() if kind.name in NUMBERS else ""
    if kind.name in NUMBERS:
        return np.zeros(kind.length, NUMBERS[kind.name])
    return [""] * kind.length


def _made(type_name: str, read: dict[str, Any], has_w: bool) -> Message:
    if type_name == QUATERNION and not has_w:
        read["w"] = 1.0
    made = message_class(type_name)
    if not read and dataclasses.fields(made):
        read = {FILLER: 0}
    return made(**read)


def _read(value: Any, kind: FieldType, path: str) -> Any:
    if kind.many:
        return _read_list(value, kind, path)
    if kind.nested:
        return message_of(value, kind.name, path)
    return _read_number(value, kind, path) if kind.name in NUMBERS else _read_text(value, path)


def _read_list(value: Any, kind: FieldType, path: str) -> Any:
    if kind.name in BINARY and isinstance(value, str):
        value = list(_decoded(value, path))
    if not isinstance(value, list):
        raise _wrong(path, value, "a list")
    if kind.length and len(value) != kind.length:
        raise MessageError(f"{path} has {len(value)} values; valid is {kind.length}")
    read = [_read(item, kind.item_kind, f"{path}[{index}]") for index, item in enumerate(value)]
    if kind.nested or kind.name not in NUMBERS:
        return read
    with np.errstate(over="ignore"):  # too large for single precision becomes infinite
        return np.array(read, NUMBERS[kind.name])


def _decoded(value: str, path: str) -> bytes:
    try:
        return base64.b64decode(value, validate=True)
    except (binascii.Error, ValueError) as error:
        raise MessageError(f"{path} is no base64: {error}") from error


def _read_number(value: Any, kind: FieldType, path: str) -> Any:
    dtype = NUMBERS[kind.name]
    if kind.name == "bool":
        if not isinstance(value, bool):
            raise _wrong(path, value, "true or false")
        return value
    if dtype.kind == "f":
        return _read_float(value, path)
    limits = np.iinfo(dtype)
    if type(value) is not int or not limits.min <= value <= limits.max:
        raise _wrong(path, value, f"a whole number from {limits.min} to {limits.max}")
    return value


def _read_float(value: Any, path: str) -> float:
    if value is None:
        return math.nan  # NaN is written as null
    if type(value) not in (int, float):
        raise _wrong(path, value, "a number")
    try:
        return float(value)
    except OverflowError:
        raise _wrong(path, value, "a number up to 1.8e308") from None


def _read_text(value: Any, path: str) -> str:
    try:
        if isinstance(value, str) and value.encode():
            return value
    except UnicodeEncodeError:  # half a surrogate pair
        pass
    if value == "":
        return ""
    raise _wrong(path, value, "a text")


def _place(path: str, name: str) -> str:
    shown = name if len(name) <= 60 else f"{name[:60]}..."
    return f"{path}.{shown}" if path else shown


def _wrong(path: str, value: Any, valid: str) -> MessageError:
    return MessageError(f"{path or 'the message'} is {shown(value)}; valid is {valid}")


def shown(value: Any) -> str:
    """Describe a JSON value in a few characters, even a large one."""
    if isinstance(value, (dict, list)):
        return f"{'an object' if isinstance(value, dict) else 'a list'} with {len(value)} values"
    if isinstance(value, int) and value.bit_length() > 200:
        return "a very large number"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."
