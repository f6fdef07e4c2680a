"""The fields of message types, for a process that does not know them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from app.ros2.dds.plan import Kind, Shapes
from app.ros2.message_types import typestore


def shapes(type_names: Iterable[str]) -> Shapes:
    """Of these message types and of all that is in them, parts before the whole."""
    found: Shapes = {}
    for name in type_names:
        _add(name, found)
    return found


def _add(name: str, found: Shapes) -> None:
    if name not in found:
        _, fields = typestore().fielddefs[name]
        found[name] = [(field, _kind(described, found)) for field, described in fields]


def _kind(described: Any, found: Shapes) -> Kind:
    """Of a field as rosbags describes it: (form, what it is made of)."""
    form, of = described
    match form.name:
        case "BASE":
            return str(of[0])
        case "NAME":
            _add(of, found)
            return str(of)
        case _:
            inner, size = of
            return [_kind(inner, found), form.name.lower(), size]
