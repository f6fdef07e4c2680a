"""Foxglove's websocket protocol, without sockets: writes and reads its messages.

Operations are JSON with an ``op``; data is bytes with an opcode. See Foxglove's specification "ws
protocol v1"; ``foxglove.sdk.v1`` has more operations; this server offers none of them.
"""

from __future__ import annotations

import json
import struct
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from app.features.ros.message_types import MessageError
from app.messages.commands import in_words

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Names of the protocol; the server accepts the first one that a viewer offers."""

MESSAGE_DATA = 1
SERVICE_CALL_REQUEST = 2
SERVICE_CALL_RESPONSE = 3
ERROR = 2
"""Level of a status."""

MOST_BYTES = 200_000
"""Longest message of a viewer [bytes]; messages to a robot are shorter."""

Number = Annotated[int, Field(ge=0, lt=2**32)]
Name = Annotated[str, Field(max_length=200)]
MOST_ITEMS = 1000


class Wish(BaseModel):
    """One topic that a viewer wants."""

    id: Number
    channel: Number = Field(alias="channelId")


class Subscribe(BaseModel):
    """A viewer subscribes to topics."""

    op: Literal["subscribe"]
    subscriptions: list[Wish] = Field(max_length=MOST_ITEMS)


class Unsubscribe(BaseModel):
    """A viewer ends subscriptions."""

    op: Literal["unsubscribe"]
    subscriptions: list[Number] = Field(alias="subscriptionIds", max_length=MOST_ITEMS)


class ClientChannel(BaseModel):
    """A topic on which a viewer will publish."""

    id: Number
    topic: Name
    encoding: Name
    type: Name = Field(alias="schemaName")


class Advertise(BaseModel):
    """A viewer advertises topics on which it will publish."""

    op: Literal["advertise"]
    channels: list[ClientChannel] = Field(max_length=MOST_ITEMS)


class Unadvertise(BaseModel):
    """A viewer ends advertisements."""

    op: Literal["unadvertise"]
    channels: list[Number] = Field(alias="channelIds", max_length=MOST_ITEMS)


class ClientMessage(BaseModel):
    """A viewer publishes a message on a topic."""

    channel: Number
    data: bytes


class ServiceCall(BaseModel):
    """A viewer calls a service."""

    service: Number
    call: Number
    encoding: str
    data: bytes


Words = Subscribe | Unsubscribe | Advertise | Unadvertise
_WORDS: TypeAdapter[Words] = TypeAdapter(Annotated[Words, Field(discriminator="op")])


def parse(data: str | bytes) -> Words | ClientMessage | ServiceCall:
    """Return a viewer's message.

    Raises:
        MessageError: the message is invalid; says what is valid.
    """
    if len(data) > MOST_BYTES:
        raise MessageError(f"a message has at most {MOST_BYTES} bytes; this has {len(data)}")
    if isinstance(data, bytes):
        return _parse_bytes(data)
    try:
        return _WORDS.validate_json(data)
    except ValidationError as error:
        raise MessageError(in_words(error)) from None


def _parse_bytes(data: bytes) -> ClientMessage | ServiceCall:
    try:
        if data[:1] == bytes([MESSAGE_DATA]):
            (channel,) = struct.unpack_from("<I", data, 1)
            return ClientMessage(channel=channel, data=data[5:])
        if data[:1] == bytes([SERVICE_CALL_REQUEST]):
            service, call, length = struct.unpack_from("<III", data, 1)
            encoding = data[13 : 13 + length].decode()
            content = data[13 + length :]
            return ServiceCall(service=service, call=call, encoding=encoding, data=content)
    except (struct.error, UnicodeDecodeError) as error:
        raise MessageError(f"the message is too short or no text: {error}") from None
    raise MessageError("the first byte is no opcode; valid are 1 (message) and 2 (service call)")


def words(op: str, **content: Any) -> str:
    """Return an operation as JSON text."""
    return json.dumps({"op": op, **content}, separators=(",", ":"))


def message_data(subscription: int, log_time_ns: int, data: bytes) -> bytes:
    """Return the bytes of a message for a subscription, with its time of publication [ns]."""
    return struct.pack("<BIQ", MESSAGE_DATA, subscription, log_time_ns) + data


def service_response(call: ServiceCall, data: bytes) -> bytes:
    """Return the bytes of the answer to a call, in the encoding of the request."""
    encoding = call.encoding.encode()
    head = struct.pack("<BIII", SERVICE_CALL_RESPONSE, call.service, call.call, len(encoding))
    return head + encoding + data
