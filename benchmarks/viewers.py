"""Run viewers without a browser: ``python -m benchmarks.viewers HOST:PORT COUNT SECONDS``."""

from __future__ import annotations

import asyncio
import json
import sys

import viser
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol


async def watch(address: str, count: int, seconds: float) -> dict[str, float]:
    """Let viewers receive as much as they can; return the rates of the slowest one [1/s]."""
    sockets = [await _viewer(address) for _ in range(count)]
    sys.stdout.write("connected\n")
    sys.stdout.flush()
    driving = asyncio.create_task(_drive(sockets[0][0]))
    async with asyncio.timeout(seconds + 30):
        rates = await asyncio.gather(
            *(_count(socket, seconds) for viewer in sockets for socket in viewer)
        )
    driving.cancel()
    for socket in (socket for viewer in sockets for socket in viewer):
        await socket.close()
    return {
        "telemetry, slowest viewer [1/s]": min(rates[0::3]),
        "pictures, slowest viewer [1/s]": min(rates[1::3]),
        "3D messages, slowest viewer [1/s]": min(rates[2::3]),
    }


async def _viewer(address: str) -> list[ClientConnection]:
    version = Subprotocol(f"viser-v{viser.__version__}")
    root = f"ws://{address}"
    return [
        await connect(f"{root}/api/live", max_size=None, compression=None),
        await connect(f"{root}/api/camera", max_size=None, compression=None),
        await connect(f"{root}/view", max_size=None, compression=None, subprotocols=[version]),
    ]


async def _count(socket: ClientConnection, seconds: float) -> float:
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    count = 0
    while loop.time() < end:
        await socket.recv()
        count += 1
    return count / seconds


async def _drive(socket: ClientConnection) -> None:
    while True:
        await socket.send(json.dumps({"type": "figure_eight"}))
        await asyncio.sleep(0.1)


if __name__ == "__main__":
    address, count, seconds = sys.argv[1:]
    rates = asyncio.run(watch(address, int(count), float(seconds)))
    sys.stdout.write(json.dumps(rates) + "\n")
