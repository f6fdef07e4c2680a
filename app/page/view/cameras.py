"""Cameras of viewers on the scene: home, from above, and behind the robot."""

from __future__ import annotations

import math
from contextvars import ContextVar
from typing import Literal

import numpy as np
import viser

from app.messages.answers import ViewCameraMessage
from robot.fields.floor_picture import Extent
from robot.geometry import Array, Pose2

Look = Literal["home", "top", "follow", "free"]
"""How a viewer looks: ``free`` leaves the camera where it is."""

PAGE: ContextVar[str] = ContextVar("page", default="")
"""The page whose viewer connects; viser tells its viewers apart by numbers of its own."""

HOME = (-0.34, -0.48, 0.52)
"""Position of the camera from the field's centre, in sizes of the field."""
BEHIND = np.array([-0.45, 0.0, 0.4])
"""Position of the camera that follows, in the robot frame [m]."""
FIELD_OF_VIEW = math.radians(75)
"""viser's own, from top to bottom."""


class Cameras:
    """Moves the cameras of viewers, by the page that they are in."""

    def __init__(self, server: viser.ViserServer, extent: Extent) -> None:
        self._server = server
        self._centre, self._size = _middle(extent)
        self._home = home(extent)
        self._clients: dict[str, int] = {}
        self._followers: set[str] = set()
        server._websock_server.on_client_connect(self._note)
        server._websock_server.on_client_disconnect(self._forget)

    async def _note(self, connection: viser.infra.WebsockClientConnection) -> None:
        """Note which page a viewer is in; viser calls this in the task that serves the viewer."""
        if page := PAGE.get():
            self._clients[page] = connection.client_id

    async def _forget(self, connection: viser.infra.WebsockClientConnection) -> None:
        """Forget a viewer that leaves, unless its page has another one by now."""
        page = PAGE.get()
        if self._clients.get(page) == connection.client_id:
            del self._clients[page]

    def look(self, page: str, look: Look) -> ViewCameraMessage | None:
        """Let a page's viewer look so; return its camera, or None if there is no such viewer."""
        if (client := self._client(page)) is None:
            return None
        self._followers.discard(page)
        if look == "follow":
            self._followers.add(page)
        elif look == "home":
            self._move(client, self._home, self._centre)
        elif look == "top":
            height = 0.5 * self._size / math.tan(FIELD_OF_VIEW / 2)
            # A little from the south: exactly above, up is nowhere.
            above = self._centre + np.array([0.0, -0.001, 1.1 * height])
            self._move(client, above, self._centre)
        seen = client.camera
        return ViewCameraMessage(position=tuple(seen.position), wxyz=tuple(seen.wxyz), fov=seen.fov)

    def follow(self, robot: Pose2) -> None:
        """Move the cameras that follow the robot."""
        place = np.array([robot.x, robot.y, 0.0])
        behind = np.append(robot.apply(BEHIND[None, :2]), BEHIND[2])
        for page in tuple(self._followers):
            if client := self._client(page):
                self._move(client, behind, place)
            else:
                self._followers.discard(page)

    def _client(self, page: str) -> viser.ClientHandle | None:
        return self._server.get_clients().get(self._clients.get(page, -1))

    def _move(self, client: viser.ClientHandle, eye: Array, target: Array) -> None:
        with client.atomic():
            client.camera.position = tuple(eye)
            client.camera.look_at = tuple(target)


def home(extent: Extent) -> Array:
    """Return where a camera is at first (3,), in the map frame [m]."""
    centre, size = _middle(extent)
    return centre + size * np.array(HOME)


def _middle(extent: Extent) -> tuple[Array, float]:
    """Return the centre of a field (3,) and its longer side [m]."""
    xmin, ymin, xmax, ymax = extent
    return np.array([(xmin + xmax) / 2, (ymin + ymax) / 2, 0.0]), max(xmax - xmin, ymax - ymin)
