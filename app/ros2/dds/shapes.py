"""The fields of message types, for the DDS process, which does not know them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from app.ros2.dds.plan import Kind, Shapes
from app.ros2.message_types import typestore


def shapes(type_names: Iterable[str]) -> Shapes:
    """Return the fields of message types and of all types in them, contained types first."""
    result: Shapes = {}
    for name in type_names:
        _add(name, result)
    return result


def _add(name: str, result: Shapes) -> None:
    if name not in result:
        _, fields = typestore().fielddefs[name]
        result[name] = [(field, _kind(described, result)) for field, described in fields]


def _kind(described: Any, result: Shapes) -> Kind:
    """Convert a field's type as rosbags describes it: (form, content)."""
    form, item_type = described
    match form.name:
        case "BASE":
            return str(item_type[0])
        case "NAME":
            _add(item_type, result)
            return str(item_type)
        case _:
            inner, size = item_type
            return [_kind(inner, result), form.name.lower(), size]
