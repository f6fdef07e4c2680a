"""Announces a participant's ROS 2 node on ``ros_discovery_info``, for ``ros2 node list``.

The message is rmw_dds_common/msg/ParticipantEntitiesInfo, with the 16-byte gids of Iron and later.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from app.ros2.dds.plan import Endpoint, Shapes

TOPIC = "ros_discovery_info"
"""The topic's name in DDS; unlike others, it has no prefix ``rt/``."""

TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"

SHAPES: Shapes = {
    "rmw_dds_common/msg/Gid": [("data", ["uint8", "array", 16])],
    "rmw_dds_common/msg/NodeEntitiesInfo": [
        ("node_namespace", "string"),
        ("node_name", "string"),
        ("reader_gid_seq", ["rmw_dds_common/msg/Gid", "sequence", 0]),
        ("writer_gid_seq", ["rmw_dds_common/msg/Gid", "sequence", 0]),
    ],
    TYPE: [
        ("gid", "rmw_dds_common/msg/Gid"),
        ("node_entities_info_seq", ["rmw_dds_common/msg/NodeEntitiesInfo", "sequence", 0]),
    ],
}

ENDPOINT = Endpoint(TOPIC, TYPE, latched=True)

PARTICIPANT_DATA = b"enclave=/;"


def endpoint_data(type_hash: str) -> bytes:
    """The user data of a reader or writer."""
    return f"typehash={type_hash};".encode() if type_hash else b""


def entities(
    participant: bytes,
    namespace: str,
    name: str,
    readers: Sequence[bytes],
    writers: Sequence[bytes],
) -> bytes:
    """Encode one participant with one node as CDR with its header; gids are those of DDS."""
    body = participant + struct.pack("<I", 1)
    for text in (namespace, name):
        body = _aligned(body) + struct.pack("<I", len(text.encode()) + 1) + text.encode() + b"\0"
    for gids in (readers, writers):
        body = _aligned(body) + struct.pack("<I", len(gids)) + b"".join(gids)
    return b"\x00\x01\x00\x00" + body


def _aligned(body: bytes) -> bytes:
    return body + bytes(-len(body) % 4)
