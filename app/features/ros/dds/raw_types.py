"""Cyclone DDS's types for messages that are sent and received as bytes.

Cyclone checks each message against its type and announces the type to others, so the types are
real. But its own serialising takes ten times as long as the rest, so the bytes are made elsewhere.
"""

from __future__ import annotations

from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct, types

from app.features.ros.dds.protocol import Kind, Shapes, dds_type

BASE: dict[str, Any] = {
    "bool": bool,
    "byte": getattr(types, "byte", types.uint8),  # 0.10.2, which a Pi has, lacks byte
    "char": types.uint8,
    "string": str,
    **{
        name: getattr(types, name)
        for name in (
            *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
            *("float32", "float64"),
        )
    },
}

ARRAY: Any = types.array
SEQUENCE: Any = types.sequence


class RawSample:
    """A received message as bytes, with its encapsulation header."""

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.sample_info: Any = None


def raw_types(shapes: Shapes) -> dict[str, type[IdlStruct]]:
    """Make a type for each shape; messages are written by ``filled`` and read as ``RawSample``."""
    made: dict[str, type[IdlStruct]] = {}
    for name, fields in shapes.items():
        members = {field: _kind(kind, made) for field, kind in fields}
        typename = dds_type(name).replace("::", ".")
        item: Any = make_idl_struct(name.rpartition("/")[2], typename, members)
        item.serialize = _serialize
        item.deserialize = staticmethod(RawSample)
        item.deserialize_key = staticmethod(RawSample)
        made[name] = item
    return made


def filled(raw_type: type[IdlStruct], data: bytes) -> IdlStruct:
    """Make a message of a type from encoded bytes with their encapsulation header."""
    message = object.__new__(raw_type)
    message.__dict__["data"] = data
    return message


def _serialize(message: Any, **_: Any) -> bytes:
    data: bytes = message.data
    return data


def _kind(kind: Kind, made: dict[str, type[IdlStruct]]) -> Any:
    if isinstance(kind, str):
        return BASE.get(kind) or made[kind]
    inner, form, size = kind
    item_kind = _kind(inner, made)
    if form == "array":
        return ARRAY[item_kind, size]
    return SEQUENCE[item_kind, size] if size else SEQUENCE[item_kind]
