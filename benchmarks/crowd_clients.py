"""A crowd of slow clients: ``python -m benchmarks.crowd_clients HOST:PORT KIND``."""

from __future__ import annotations

import asyncio
import base64
import json
import socket
import sys
from collections.abc import Callable, Coroutine
from contextlib import closing, suppress
from typing import Any

from app.operating_system import raise_descriptors

READERS = 50
HEADS = 300
SOCKETS = 1000

SMALL_BUFFER = 4096
BITE = 1024
"""A slow reader takes so much at a time [bytes]."""
PAUSE_S = 0.25
RETRY_S = 1.0
"""After this time [s], a client that was closed comes again."""

Client = Callable[[str], Coroutine[Any, Any, None]]
PICTURES = json.dumps({"op": "subscribe", "topic": "/camera/image/compressed"})


def get(path: str, address: str) -> bytes:
    """Return a request's head, without its end."""
    return f"GET {path} HTTP/1.1\r\nHost: {address}\r\n".encode()


def upgrade(path: str, address: str) -> bytes:
    """Return a request for a websocket."""
    key = base64.b64encode(bytes(16)).decode()
    rest = (
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Key: {key}\r\n\r\n"
    )
    return get(path, address) + rest.encode()


def text_frame(text: str) -> bytes:
    """Return a text of at most 125 bytes as a frame of a client; its mask is zero."""
    data = text.encode()
    return bytes([0x81, 0x80 | len(data)]) + bytes(4) + data


async def connect(address: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """Open a connection that holds little of what waits."""
    host, _, port = address.rpartition(":")
    raw = socket.socket()
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
    raw.setblocking(False)
    await asyncio.get_running_loop().sock_connect(raw, (host, int(port)))
    return await asyncio.open_connection(sock=raw, limit=BITE)


def reads(path: str, wish: bytes = b"") -> Client:
    """Return a client that opens a websocket, says something, and reads slowly."""

    async def read(address: str) -> None:
        reader, writer = await connect(address)
        with closing(writer):
            writer.write(upgrade(path, address))
            await reader.readuntil(b"\r\n\r\n")
            writer.write(wish)
            await taste(reader)

    return read


async def watch(address: str) -> None:
    """Read the camera's pictures slowly."""
    reader, writer = await connect(address)
    with closing(writer):
        writer.write(get("/camera.mjpg", address) + b"\r\n")
        await taste(reader)


async def taste(reader: asyncio.StreamReader) -> None:
    """Read slowly, until the server closes."""
    while await reader.read(BITE):
        await asyncio.sleep(PAUSE_S)


async def spell(address: str) -> None:
    """Send a head letter by letter."""
    _, writer = await connect(address)
    with closing(writer):
        writer.write(get("/", address) + b"X: ")
        while True:
            writer.write(b"x")
            await writer.drain()
            await asyncio.sleep(PAUSE_S)


async def wait(address: str) -> None:
    """Say nothing, until the server closes; then stay away."""
    reader, writer = await connect(address)
    with closing(writer):
        await reader.read()
    await asyncio.Event().wait()


CROWDS: dict[str, tuple[Client, int]] = {
    "live": (reads("/api/live"), READERS),
    "mjpg": (watch, READERS),
    "camera": (reads("/api/camera"), READERS),
    "rosbridge": (reads("/rosbridge", text_frame(PICTURES)), READERS),
    "heads": (spell, HEADS),
    "sockets": (wait, SOCKETS),
}
"""Clients by kind, and how many there are of each."""


async def gather(address: str, kind: str) -> None:
    """Let a crowd come and stay, until this process is ended."""
    client, count = CROWDS[kind]

    async def stay() -> None:
        while True:
            with suppress(OSError, asyncio.IncompleteReadError):  # it is closed
                await client(address)
            await asyncio.sleep(RETRY_S)

    async with asyncio.TaskGroup() as tasks:
        for _ in range(count):
            tasks.create_task(stay())
        await asyncio.sleep(RETRY_S)
        sys.stdout.write("there\n")
        sys.stdout.flush()


if __name__ == "__main__":
    raise_descriptors()
    asyncio.run(gather(*sys.argv[1:]))
