"""``view``: the page of a program that Python steps itself, as in a notebook."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from html import escape
from types import TracebackType

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.engine.program import LocalProgram, Program
from app.engine.snapshot import Snapshot
from app.page.listening import listen
from app.page.serving import Server
from robot.errors import BrickPoseError

START_S = 20.0
"""How long the page may take to be served on a busy machine [s]."""
HEIGHT_PX = 720
NOTEBOOKS = (
    "http://localhost:*",
    "http://127.0.0.1:*",
    "https://localhost:*",
    "vscode-webview:",
)
"""Pages of this computer that may show the page in a frame: Jupyter's, and editors'."""


class ViewError(BrickPoseError, RuntimeError):
    """The page could not be served."""


def view(program: LocalProgram, *, height: int = HEIGHT_PX, port: int = 0) -> ShownPage:
    """Show the page of a program; as the last line of a notebook's cell, it appears below.

    The engine is not run by it: ``program.engine.step()`` goes on by a tick, and the page shows
    each; ``run`` of what is returned goes on for a time, as fast as a robot drives. What is
    pressed on the page is carried out with the next tick. Only this computer can open it.

    Args:
        program: of ``build_program``.
        height: of the page in the notebook [px].
        port: where it is served; 0 is any that is free.

    Raises:
        ViewError: the page could not be served.
        SettingError: the port is in use.
    """
    return ShownPage(program, height, port)


class ShownPage:
    """A page that is served until ``close``; a context that closes it."""

    def __init__(self, program: LocalProgram, height: int = HEIGHT_PX, port: int = 0) -> None:
        """Serve it from now on."""
        self.program = program
        self._height = height
        listening = listen("127.0.0.1", port)
        self.address = f"http://127.0.0.1:{listening.getsockname()[1]}/"
        """Where a browser finds the page."""
        self._server = _FramedServer(replace(program, loop=_wait_for_the_end))
        self._thread = threading.Thread(
            target=self._server.run, args=(listening,), name="notebook's page", daemon=True
        )
        self._thread.start()
        end = time.monotonic() + START_S
        while not self._server.started:
            if not self._thread.is_alive() or time.monotonic() > end:
                raise ViewError(f"the page could not be served at {self.address}")
            time.sleep(0.01)

    def __enter__(self) -> ShownPage:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """Return the page as a frame, which notebooks show."""
        return (
            f'<iframe src="{escape(self.address)}" title="BrickPose" width="100%" '
            f'height="{self._height}" style="border: 0"></iframe>'
        )

    def run(self, seconds: float, *, speed: float = 1.0) -> Snapshot:
        """Let the robot go on for a time; return the last tick.

        Args:
            seconds: of the robot's clock.
            speed: 1 is as fast as it drives, 10 ten times as fast; inf waits for nothing.
        """
        began = time.monotonic()
        shown = self.program.engine.step()
        start = shown.stamp
        while shown.stamp < start + seconds:
            ahead = (shown.stamp - start) / speed - (time.monotonic() - began)
            if ahead > 0:
                time.sleep(ahead)
            shown = self.program.engine.step()
        return shown

    def close(self) -> None:
        """Serve it no longer; the program can go on without."""
        self._server.stop()
        self._thread.join(START_S)


class _FramedServer(Server):
    """A server whose engine is stepped by others, and whose page notebooks may frame."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        config = self._uvicorn.config
        config.app = _InFrames(config.app)  # type: ignore[arg-type]

    @property
    def started(self) -> bool:
        """Whether it answers."""
        return self._uvicorn.started


def _wait_for_the_end(stopping: threading.Event) -> None:
    """Stand in for the engine's loop: its steps are somebody else's."""
    stopping.wait()


class _InFrames:
    """Lets pages of notebooks on this computer show the page in a frame, and no others.

    The browser holds others off by ``frame-ancestors``; so a page that is opened in a frame may
    come from another site as far as the application is asked.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def send_framed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers["Content-Security-Policy"] = f"frame-ancestors 'self' {' '.join(NOTEBOOKS)}"
                del headers["X-Frame-Options"]
            await send(message)

        if scope["type"] == "http":
            headers = Headers(scope=scope)
            opened = headers.get("sec-fetch-mode"), headers.get("sec-fetch-dest")
            if opened == ("navigate", "iframe"):
                scope["headers"] = [
                    pair for pair in scope["headers"] if pair[0].lower() != b"sec-fetch-site"
                ]
        await self._app(scope, receive, send_framed)
