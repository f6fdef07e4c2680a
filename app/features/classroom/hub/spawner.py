"""StudentSpawner: starts a student's server as a copy of a warm process, else as one of its own."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from jupyterhub.spawner import SimpleLocalProcessSpawner
from jupyterhub.utils import random_port
from traitlets import Bool, Dict, Float, Int, List, Unicode

from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.warm.ending import STUDENT_OF
from app.features.classroom.warm.request import Confinement, CopyRequest, ask, start_parent
from app.features.classroom.warm.request import WarmParentError as NotWarmError

FIRST_START = "BRICKPOSE_CLASS_STARTS"
"""In the environment of a hub that is not one begun again."""
LOOK_S = 0.01
MOST_STARTS = 5
WITHIN_S = 60.0
"""A server that died so often within this time [s] is left dead: its files may kill it."""


class StudentSpawner(SimpleLocalProcessSpawner):
    """A server of a student's own, in a folder of their own; it is begun again if it dies."""

    class_folder = Unicode(help="The class's folder.").tag(config=True)
    warm = Bool(True, help="Copy a warm process where that is possible.").tag(config=True)
    disk_mb = Int(0, help="Most room of a student's folder [MB]; 0 is no limit.").tag(config=True)
    started_at = Float(0.0)
    request = Dict()
    starts = List()

    def __init__(self, *words: Any, **named: Any) -> None:
        super().__init__(*words, **named)
        # Pages and the clock may ask at once: the second would replace what the first has begun.
        self._polling = asyncio.Lock()

    def _default_home_dir(self) -> str:
        return str(self._folder.home_of(self.user.name))

    @property
    def _folder(self) -> ClassFolder:
        return ClassFolder(Path(self.class_folder))

    def user_env(self, env: dict[str, str]) -> dict[str, str]:
        """Return the environment with the student's own folders."""
        home = self._default_home_dir()
        return env | {
            "HOME": home, "USER": self.user.name, "TMPDIR": f"{home}/.tmp",
            "XDG_DATA_HOME": f"{home}/.local/share", "XDG_STATE_HOME": f"{home}/.local/state",
            STUDENT_OF: str(self._folder.path),
        }  # fmt: skip

    async def start(self) -> tuple[str, int]:
        """Start the server; return where it listens."""
        port = int(getattr(self, "port", 0)) or random_port()
        self.port = port
        home = Path(self._default_home_dir())
        home.mkdir(mode=0o700, exist_ok=True)
        (home / ".tmp").mkdir(mode=0o700, exist_ok=True)
        self.home_dir = str(home)
        if not self.warm:
            return await self._start_cold()
        memory = int(self.mem_limit or 0)
        hub_port = urlsplit(self.hub.api_url).port or 80
        place = str(self._folder.path)
        disk = self.disk_mb << 20
        confined = Confinement(place, str(home), self.user.id, memory, port, hub_port, disk)
        words = [*self.cmd[3:], *self.get_args()]
        request = CopyRequest(words, self.get_env(), str(home), confined)
        self.request = request.to_json()
        try:
            await self._copy()
        except NotWarmError as error:
            self.log.warning("%s's server starts cold: %s", self.user.name, error)
            return await self._start_cold()
        await until_listening(port, lambda: _started_at(self.pid) == self.started_at)
        return str(self.ip or "127.0.0.1"), port

    async def _start_cold(self) -> tuple[str, int]:
        host, port = await super().start()
        return str(host), int(port)

    async def _copy(self, *, died: bool = False) -> None:
        place = self._folder.warm_socket
        loop = asyncio.get_running_loop()
        await loop.run_in_executor(None, start_parent, place)
        asked = partial(ask, place, CopyRequest.from_json({**self.request, "died": died}))
        self.pid = await loop.run_in_executor(None, asked)
        self.started_at = _started_at(self.pid)
        self.starts = [*self.starts, time.monotonic()][-MOST_STARTS:]

    async def poll(self) -> int | None:
        """Return None while it runs; a copy that has died by itself is begun again, as it was."""
        if self.proc is not None or not self.request:
            status: int | None = await super().poll()
            return status
        async with self._polling:
            return await self._poll_copy()

    async def _poll_copy(self) -> int | None:
        if self.pid and _started_at(self.pid) == self.started_at:
            return None
        often = len(self.starts) >= MOST_STARTS and time.monotonic() - self.starts[0] < WITHIN_S
        if not self._stop_pending and self.pid and not often:
            self.log.warning("%s's server died; it is begun again", self.user.name)
            try:
                await self._copy(died=True)
            except NotWarmError as error:
                self.log.warning("%s", error)
            else:
                # The hub keeps the state itself only when it has started a server.
                self.orm_spawner.state = self.get_state()
                self.db.commit()
                return None
        self.clear_state()
        return 1

    def get_state(self) -> dict[str, Any]:
        """Return what a hub that is started again has to know."""
        kept = {"started_at": self.started_at, "request": self.request}
        state: dict[str, Any] = super().get_state()
        return state | (kept if self.pid else {})

    def load_state(self, state: dict[str, Any]) -> None:
        """Take over a server of a hub that has died; those of an earlier lesson were ended."""
        super().load_state(state)
        if os.environ.get(FIRST_START):
            self.pid = 0
            return
        self.started_at = state.get("started_at", 0.0)
        self.request = state.get("request", {})

    def clear_state(self) -> None:
        """Forget a server that has ended."""
        super().clear_state()
        self.started_at, self.request = 0.0, {}


async def until_listening(port: int, lives: Callable[[], bool]) -> None:
    """Wait until a server of this machine listens, or has died.

    The hub would ask itself, but after 0.2 s, then after 0.4 s, and so on: a copy needs 0.1 s.
    """
    while lives():
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
        except OSError:
            await asyncio.sleep(LOOK_S)
        else:
            writer.close()
            return


def _started_at(pid: int) -> float:
    """Return when a process began, in ticks since the machine's start; 0 if it has ended."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return 0.0 if fields[0] == "Z" else float(fields[19])
