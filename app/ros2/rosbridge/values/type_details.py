"""Describes the fields of a type, in the form of rosapi's TypeDef."""

from __future__ import annotations

from typing import Any

from app.ros2.message_types import typestore
from app.ros2.rosbridge.values.fields import NUMBERS, Kind, fields

ONE = -1
"""The array length of a field that is not an array."""


def type_details(type_name: str) -> list[dict[str, Any]]:
    """Describe a type and all types in it, each once, beginning with the type itself.

    Raises:
        MessageError: the type is unknown.
    """
    result: dict[str, dict[str, Any]] = {}
    waiting = [type_name]
    while waiting:
        name = waiting.pop(0)
        if name not in result:
            result[name] = _details(name)
            waiting += [kind.name for kind in fields(name).values() if kind.nested]
    return list(result.values())


def _details(name: str) -> dict[str, Any]:
    kinds = fields(name)
    constants = typestore().fielddefs[name][0]
    return {
        "type": name,
        "fieldnames": list(kinds),
        "fieldtypes": [kind.name for kind in kinds.values()],
        "fieldarraylen": [kind.length if kind.many else ONE for kind in kinds.values()],
        "examples": [_example(kind) for kind in kinds.values()],
        "constnames": [constant[0] for constant in constants],
        "constvalues": [str(constant[2]) for constant in constants],
    }


def _example(kind: Kind) -> str:
    if kind.many:
        return "[]"
    if kind.nested:
        return "{}"
    return str(NUMBERS[kind.name].type(0).item()) if kind.name in NUMBERS else ""
