"""A participant of DDS that looks like a node of ROS 2, and its sockets.

Cyclone DDS sends on the configured interface, but its sockets listen on all interfaces. So another
machine could still send commands and drive the robot. Sockets that are bound to the loopback
device receive only what was sent on this machine, to any of its addresses.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from cyclonedds.core import (
    DDSException,
    GuardCondition,
    InstanceState,
    Policy,
    Qos,
    ReadCondition,
    SampleState,
    ViewState,
    WaitSet,
)
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from app.features.ros.dds.protocol import Endpoint, Plan, Shapes, dds_topic
from app.features.ros.dds.raw_types import RawSample, filled, raw_types
from robot.errors import BrickPoseError

DEVICE = b"lo\0"
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
BLOCKING_S = 0.01
"""Longest time that a writer waits for a slow reader [s]; the other writers wait too."""
UNREAD = ViewState.Any | SampleState.NotRead | InstanceState.Any


class ConfinementError(BrickPoseError, OSError):
    """The system does not allow binding the sockets to the loopback device."""


def confine_to_this_machine() -> None:
    """Bind each UDP socket of this process to the loopback device.

    Raises:
        ConfinementError: the system does not allow it.
    """
    if not sys.platform.startswith("linux"):
        raise ConfinementError("only Linux can keep DDS to this machine")
    for each in _udp_sockets():
        with each:
            try:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, DEVICE)
            except OSError as error:
                raise ConfinementError(
                    f"DDS cannot be kept to this machine ({error.strerror}); Linux 5.7 or newer can"
                ) from error


def _udp_sockets() -> Iterator[socket.socket]:
    for entry in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # the folder's own descriptor is closed by now
            if not str(entry.readlink()).startswith("socket:"):
                continue
            item = socket.socket(fileno=os.dup(int(entry.name)))
            if item.family in (socket.AF_INET, socket.AF_INET6) and item.type == socket.SOCK_DGRAM:
                yield item
            else:
                item.close()


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


class WriteError(BrickPoseError, ValueError):
    """DDS refuses a message."""


class Participant:
    """The writers and readers of a plan; numbers are indices in the plan."""

    def __init__(self, plan: Plan) -> None:
        if plan.configuration is not None:
            self._domain = Domain(plan.domain, plan.configuration)
        self._participant = DomainParticipant(plan.domain, Qos(Policy.Userdata(PARTICIPANT_DATA)))
        if plan.confined:
            confine_to_this_machine()  # before there are readers
        self._types = raw_types(plan.shapes | SHAPES)
        self._writers = [
            self._writer(planned, dds_topic(planned.topic)) for planned in plan.writers
        ]
        self._readers = [self._reader(each) for each in plan.readers]
        self._names = [item.topic for item in plan.writers]
        self._latched = [writer.latched for writer in plan.writers]
        self._waiting: dict[int, bytes] = {}
        self._graph = self._writer(ENDPOINT, TOPIC)
        self._tell_node(plan)
        self._ending = GuardCondition(self._participant)
        self._waitset = WaitSet(self._participant)
        self._waitset.attach(self._ending)
        self._conditions = [ReadCondition(reader, UNREAD) for reader in self._readers]
        for condition in self._conditions:
            self._waitset.attach(condition)

    def write(self, number: int, data: bytes) -> None:
        """Publish a message; if a latched topic cannot take it now, the next call sends it.

        Raises:
            WriteError: DDS refuses the bytes, because they are not of the topic's type.
        """
        waiting, self._waiting = self._waiting | {number: data}, {}
        for item, message in waiting.items():
            try:
                self._writers[item].write(filled(self._writers[item].data_type, message))
            except DDSException as error:
                if error.code != DDSException.DDS_RETCODE_TIMEOUT:
                    raise WriteError(f"{self._names[item]}: {_reason(error)}") from error
                if self._latched[item]:
                    self._waiting[item] = message

    def heard(self, seconds: float) -> list[tuple[int, bytes]]:
        """Wait for messages, at most some seconds; return the newest of each topic that has any."""
        self._waitset.wait(duration(seconds=seconds))
        result = []
        for number, (reader, condition) in enumerate(
            zip(self._readers, self._conditions, strict=True)
        ):
            taken: list[object] = list(reader.take(1, condition=condition))
            # When a writer leaves, a message without data arrives.
            result += [(number, item.data) for item in taken if isinstance(item, RawSample)]
        return result

    def wake(self) -> None:
        """Make ``heard`` return at once from now on."""
        self._ending.set(True)

    def _writer(self, endpoint: Endpoint, topic: str) -> DataWriter[IdlStruct]:
        named = Topic(self._participant, topic, self._types[endpoint.type])
        return DataWriter(self._participant, named, _quality(endpoint))

    def _reader(self, endpoint: Endpoint) -> DataReader[IdlStruct]:
        named = Topic(self._participant, dds_topic(endpoint.topic), self._types[endpoint.type])
        return DataReader(self._participant, named, _quality(endpoint))

    def _tell_node(self, plan: Plan) -> None:
        given = entities(
            self._participant.guid.bytes,
            plan.namespace,
            plan.name,
            [reader.guid.bytes for reader in self._readers],
            [writer.guid.bytes for writer in self._writers],
        )
        self._graph.write(filled(self._graph.data_type, given))


def _reason(error: DDSException) -> str:
    if error.code == DDSException.DDS_RETCODE_BAD_PARAMETER:
        return "these bytes are no message of its type"
    return str(error).partition(" Occurred")[0]


def _quality(endpoint: Endpoint) -> Qos:
    """Quality of service of a writer or reader.

    Only XCDR1 is offered: if XCDR2 is offered too, Fast DDS matches and then drops all data.
    """
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=BLOCKING_S))
        if endpoint.reliable
        else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if endpoint.latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(endpoint.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        Policy.Userdata(endpoint_data(endpoint.type_hash)),
    )
