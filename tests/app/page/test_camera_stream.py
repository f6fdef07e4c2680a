"""What goes to the page with a picture."""

import asyncio
import struct
import threading
from dataclasses import replace

from engine_runs import kinematic, run
from starlette.websockets import WebSocket, WebSocketState

from app.engine.mailboxes.latest import Latest
from app.engine.rest import Audience
from app.messages.telemetry import PictureMessage
from app.page.camera_stream import CameraStream


def head(message: bytes) -> PictureMessage:
    (length,) = struct.unpack("<I", message[:4])
    return PictureMessage.model_validate_json(message[4 : 4 + length])


def served(*snapshots) -> list[PictureMessage]:
    """What a page gets that stays for as many pictures."""
    latest, messages, gone = Latest(), [], asyncio.Event()
    stream, left = CameraStream(latest, threading.Event(), Audience()), iter(snapshots)

    async def send(message):
        if message["type"] == "websocket.send":
            messages.append(head(message["bytes"]))
        following = next(left, None)
        if following is None:
            gone.set()
        else:
            latest.put(following)

    async def receive():
        if socket.client_state is WebSocketState.CONNECTING:
            return {"type": "websocket.connect"}
        await gone.wait()
        return {"type": "websocket.disconnect", "code": 1001}

    socket = WebSocket({"type": "websocket"}, receive, send)
    asyncio.run(asyncio.wait_for(stream.serve(socket), 30))
    return messages


def test_a_picture_that_was_not_scanned_comes_without_the_edges_of_an_older_one():
    """As one that came too late to be used."""
    program = kinematic(map="stub")
    snapshot = run(program, 0.5)[-1]
    late = replace(snapshot.frame, stamp=snapshot.frame.stamp + 0.03)
    first, other = served(snapshot, replace(snapshot, frame=late))
    assert first.edges is not None
    assert (other.stamp, other.edges) == (late.stamp, None)
