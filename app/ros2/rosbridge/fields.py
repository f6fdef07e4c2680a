"""The fields of ROS types, as rosbags describes them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from app.ros2.message_types import message_class, typestore

FILLER = "structure_needs_at_least_one_member"
"""The field that an empty type has in its bytes; no client ever sees it."""

NUMBERS: dict[str, np.dtype[Any]] = {
    **{f"int{bits}": np.dtype(f"int{bits}") for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": np.dtype(f"uint{bits}") for bits in (8, 16, 32, 64)},
    "byte": np.dtype("int8"),  # as rosbags has it
    "char": np.dtype("uint8"),
    "bool": np.dtype("bool"),
    "float32": np.dtype("float32"),
    "float64": np.dtype("float64"),
}
"""Base types that are numbers, with NumPy's types for arrays of them."""


@dataclass(frozen=True, slots=True)
class Kind:
    """The type of a field."""

    name: str
    """Name of a base type or of a message type."""
    nested: bool
    """Whether it is a message."""
    many: bool = False
    """Whether it is a list or an array of the named type."""
    length: int = 0
    """Length of an array; 0 means any length."""

    @property
    def item_kind(self) -> Kind:
        """The type of one item of a list."""
        return Kind(self.name, self.nested)


@cache
def fields(type_name: str) -> dict[str, Kind]:
    """The fields of a message type, in their order.

    Raises:
        MessageError: the type is unknown.
    """
    message_class(type_name)
    described = typestore().fielddefs[type_name][1]
    return {name: _kind(description) for name, description in described if name != FILLER}


def _kind(description: Any) -> Kind:
    from rosbags.interfaces import Nodetype  # noqa: PLC0415 -- as for the type store

    form, content = description
    if form == Nodetype.NAME:
        return Kind(content, nested=True)
    if form == Nodetype.BASE:
        return Kind(content[0], nested=False)
    inner = _kind(content[0])
    fixed = content[1] if form == Nodetype.ARRAY else 0
    return Kind(inner.name, inner.nested, many=True, length=fixed)


def full_type(name: str, between: str) -> str:
    """Return a type's full name: ``geometry_msgs/msg/Twist`` for ROS 1's ``geometry_msgs/Twist``.

    Args:
        name: as a client gives it.
        between: ``msg`` or ``srv``.
    """
    package, slash, rest = name.partition("/")
    return name if not slash or "/" in rest else f"{package}/{between}/{rest}"
