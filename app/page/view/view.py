"""viser on our own port: its page at ``/view/``, its messages by our websocket at ``/view``."""

from __future__ import annotations

import contextlib
import hashlib
import io
import threading
from collections.abc import Iterable
from functools import cache, partial
from pathlib import Path

import anyio
import anyio.to_thread
import viser
import viser._messages
from starlette.requests import Request
from starlette.responses import Response
from starlette.websockets import WebSocket

from app.engine.mailboxes.latest import Latest
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.page.view.cameras import Cameras
from app.page.view.paths import Path as Walked
from app.page.view.scene import NewViewLayer, Scene
from app.page.view.viewers import Viewers, without_port
from robot.description.spec import RobotSpec
from robot.fields.field import Field

UPDATES_HZ = 15

PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
"""viser's whole client is this one file."""

INJECTED_HTML = b"""<style>[data-floating-window]{display:none!important}</style>
<script>document.hasFocus = () => true;</script>"""
"""Added to viser's page. Our page has the controls, so viser's panel is hidden. viser's client
reconnects only while it has the focus, which a frame in a page often lacks."""


class View:
    """A viser server that listens nowhere: who may see the page is handed over to it."""

    def __init__(
        self,
        field: Field,
        spec: RobotSpec,
        latest: Latest[Snapshot],
        layers: Iterable[NewViewLayer] = (),
    ) -> None:
        """Make a view of a robot on a field.

        Args:
            field: the floor.
            spec: the robot.
            latest: what is shown.
            layers: what makes layers of features.
        """
        self._viewers = Viewers()
        # viser prints its own address.
        with contextlib.redirect_stdout(io.StringIO()), without_port(self._viewers):
            self._server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        # viser's share button would make this server call one on the internet.
        self._server._websock_server.unregister_handler(viser._messages.ShareUrlRequest)
        self._paths = {"truth": Walked(), "odometry": Walked(), "estimate": Walked()}
        self._new_scene = partial(Scene, self._server, field, spec, layers, self._paths)
        self._made: Scene | None = None
        self._making = threading.Lock()
        self.cameras = Cameras(self._server, field.floor.extent)
        self._latest = latest
        self.failure: str | None = None
        """Why the view stopped, if it failed."""
        self._page, self._tag = _page()

    @property
    def _scene(self) -> Scene:
        """The scene, made for the first who looks: most of what the view costs."""
        with self._making:
            if self._made is None:
                self._made = self._new_scene()
            return self._made

    def page(self, request: Request) -> Response:
        """Return viser's page, or status 304 to a browser that has it."""
        headers = {"ETag": self._tag, "Cache-Control": "no-cache"}
        if request.headers.get("if-none-match") == self._tag:
            return Response(status_code=304, headers=headers)
        return Response(self._page, media_type="text/html", headers=headers)

    async def follow(self) -> None:
        """Keep the scene up to date, until cancelled; a failure ends only the 3D view."""
        try:
            with self._latest.subscribe() as subscription:
                while True:
                    snapshot = await subscription.next()
                    self._remember(snapshot)
                    if self._viewers.present:
                        await anyio.to_thread.run_sync(self._show, snapshot)
                    await anyio.sleep(1 / UPDATES_HZ)
        except Exception as error:
            LOG.exception("the 3D view stopped")
            self.failure = f"The 3D view stopped: {error}"

    def _show(self, snapshot: Snapshot) -> None:
        self._scene.update(snapshot)
        self.cameras.follow(snapshot.truth or snapshot.pose or snapshot.odometry)

    def _remember(self, snapshot: Snapshot) -> None:
        """Keep what paths show later, also of a snapshot that nobody looks at."""
        self._paths["truth"].add(snapshot.truth)
        self._paths["odometry"].add(snapshot.odometry)
        self._paths["estimate"].add(snapshot.pose)

    async def serve(self, socket: WebSocket) -> None:
        """Let viser serve one viewer, until one side ends."""
        # viser shows its own light and no floor until there is a scene.
        await anyio.to_thread.run_sync(lambda: self._scene)
        await self._viewers.serve(socket)

    def close(self) -> None:
        """End viser's threads."""
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()


@cache
def _page() -> tuple[bytes, str]:
    """Return viser's page and its tag."""
    page = PAGE.read_bytes()
    head = page.index(b"<head>") + len(b"<head>")
    page = page[:head] + INJECTED_HTML + page[head:]
    return page, f'"{hashlib.sha256(page).hexdigest()[:16]}"'
