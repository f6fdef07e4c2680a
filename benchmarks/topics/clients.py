"""Clients of rosbridge and Foxglove that read every topic at the rates of the settings."""

from __future__ import annotations

import asyncio
import json
import sys

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

from app.features.ros.publisher import sent_every
from app.features.ros.topics import TOPICS
from app.settings.groups import Ros2Settings

FOXGLOVE = Subprotocol("foxglove.sdk.v1")


async def read_all(address: str) -> None:
    """Receive messages until this process is ended."""
    async with (
        connect(f"ws://{address}/rosbridge", max_size=None, compression=None) as bridge,
        connect(f"ws://{address}/foxglove", max_size=None, subprotocols=[FOXGLOVE]) as fox,
    ):
        for topic in TOPICS:
            wish = {"op": "subscribe", "topic": f"/{topic.name}", "compression": "cbor"}
            rate = {"throttle_rate": 1000 * sent_every(topic, Ros2Settings())}
            await bridge.send(json.dumps(wish | rate))
        await asyncio.gather(_take(bridge), _take(fox))


async def _take(socket: ClientConnection) -> None:
    first = True
    async for message in socket:
        content = json.loads(message) if isinstance(message, str) else {}
        if content.get("op") == "advertise":
            wishes = [
                {"id": channel["id"], "channelId": channel["id"]} for channel in content["channels"]
            ]
            await socket.send(json.dumps({"op": "subscribe", "subscriptions": wishes}))
        if first:
            sys.stdout.write("reading\n")
            sys.stdout.flush()
        first = False


if __name__ == "__main__":
    asyncio.run(read_all(*sys.argv[1:]))
