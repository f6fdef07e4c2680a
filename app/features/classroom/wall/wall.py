"""Wall: who is in the class, and what their robots do; follows each running server."""

from __future__ import annotations

import json
import os
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from app.engine.problems import LOG
from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.hub_client import SHARED_ROBOT, HubClient, HubError
from app.features.classroom.roster import TEACHER
from app.features.classroom.wall.followed import FollowedServer
from app.features.reverse_proxy.jupyter import NAME as IN_JUPYTER

LOOK_S = 1.0


class Wall:
    """Follows the servers of all students of a hub."""

    def __init__(self, hub: HubClient, address: str, folder: ClassFolder | None) -> None:
        """Prepare to follow.

        Args:
            hub: the hub, asked in the service's name.
            address: of the hub's proxy, by which the students' servers are reached.
            folder: the class's, if it lies on this machine.
        """
        self.hub = hub
        self.folder = folder
        self._address = address
        shared = os.environ.get(SHARED_ROBOT)
        base = hub.environment.base_url
        self.shared = (
            FollowedServer(f"{address}{base}{shared}", hub.environment.api_token)
            if shared
            else None
        )
        """The robot that the class shares, if there is one."""
        self._servers: dict[str, FollowedServer] = {}
        self._scopes: dict[str, anyio.CancelScope] = {}
        self._pending: set[str] = set()
        self.names: dict[str, str] = {}

    async def run(self) -> None:
        """Follow, until cancelled."""
        async with anyio.create_task_group() as tasks:
            while True:
                try:
                    await self._look(tasks)
                except HubError as error:
                    LOG.warning("the wall: %s", error)
                await anyio.sleep(LOOK_S)

    async def _look(self, tasks: TaskGroup) -> None:
        users = await anyio.to_thread.run_sync(self.hub.get, "users?limit=500")
        written = self._written_names()
        students = [user["name"] for user in users if user["name"] != TEACHER]
        self.names = {login: written.get(login, login) for login in (*written, *students)}
        running = {u["name"]: u["servers"][""]["url"] for u in users if _is_ready(u)}
        self._pending = {user["name"] for user in users if user.get("pending")}
        for login in set(self._servers) - set(running):
            self._scopes.pop(login).cancel()
            del self._servers[login]
        for login in set(running) - set(self._servers) - {TEACHER}:
            place = f"{self._address}{running[login]}"
            server = FollowedServer(place, self.hub.environment.api_token)
            self._servers[login], self._scopes[login] = server, anyio.CancelScope()
            tasks.start_soon(self._follow, server, self._scopes[login])
        await self.of_each(None, FollowedServer.look)

    async def _follow(self, server: FollowedServer, scope: anyio.CancelScope) -> None:
        with scope:
            await server.follow()

    def _written_names(self) -> dict[str, str]:
        if self.folder is None:
            return {}
        try:
            names: dict[str, str] = json.loads(self.folder.names.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return names

    def tiles(self) -> list[dict[str, Any]]:
        """Return what the wall shows of each student."""
        return [self._tile(login, name) for login, name in self.names.items()]

    def _tile(self, login: str, name: str) -> dict[str, Any]:
        server = self._servers.get(login)
        base = {"login": login, "name": name, "pending": login in self._pending}
        if server is None:
            return base | {"awake": False}
        url = server.address.removeprefix(self._address)
        if server.foreign:
            return base | {"awake": True, "notebook": True, "url": f"{url}{IN_JUPYTER}/"}
        telemetry, desk = server.telemetry, server.desk
        shown = ("map", "truth", "estimate", "integrity", "mode", "driver", "twist")
        return base | {
            "awake": True,
            "url": url,
            **{key: telemetry.get(key) for key in shown},
            "extent": server.area.get("extent"),
            "frozen": desk.get("frozen", False),
            "message": desk.get("message", ""),
            "handed": desk.get("lesson", 0),
            "hand": desk.get("hand", False),
            "lesson": server.progress.get("lesson"),
            "passed": len(server.progress.get("passed", ())),
            "begun": len(server.progress.get("begun", ())),
            "asleep": desk.get("asleep", False),
        }

    def servers(self) -> dict[str, FollowedServer]:
        """Return the servers that run, by whose they are."""
        return dict(self._servers)

    async def of_each(
        self,
        logins: Sequence[str] | None,
        ask: Callable[[FollowedServer], Awaitable[Any]],
    ) -> dict[str, Any]:
        """Ask students' dashboards at once, all or those named; return each one's answer."""
        answers: dict[str, Any] = {}

        async def ask_one(login: str, server: FollowedServer) -> None:
            answers[login] = await ask(server)

        async with anyio.create_task_group() as tasks:
            for login, server in tuple(self._servers.items()):
                if not server.foreign and (logins is None or login in logins):
                    tasks.start_soon(ask_one, login, server)
        return answers

    async def start_all(self) -> int:
        """Start the servers of all who have none; return how many."""
        waiting = [n for n in self.names if n not in self._servers and n not in self._pending]

        def start(login: str) -> bool:
            try:
                self.hub.post(f"users/{login}")
            except HubError as error:
                if error.errno != 409:  # 409: the hub knows the user already
                    raise
            self.hub.post(f"users/{login}/server")
            return True

        for login in waiting:
            await anyio.to_thread.run_sync(start, login)
        return len(waiting)

    async def queue(self, wish: dict[str, str] | None = None) -> dict[str, Any] | None:
        """Return the queue of the shared robot, after a wish; None if there is none."""
        if self.shared is None:
            return None
        queue: dict[str, Any] | None = await self.shared.ask("queue", wish)
        return queue and queue | {"url": self.shared.address.removeprefix(self._address)}

    async def picture(self, login: str) -> bytes | None:
        """Return the floor of a student's field; None if there is none."""
        server = self._servers.get(login)
        return None if server is None else await server.read("api/field.png")


def _is_ready(user: dict[str, Any]) -> bool:
    return bool(user.get("servers", {}).get("", {}).get("ready"))


def class_folder_of(environment: os._Environ[str] | dict[str, str]) -> ClassFolder | None:
    """Return the class's folder on this machine; None if the environment names none."""
    path = environment.get("BRICKPOSE_CLASS")
    return ClassFolder(Path(path)) if path else None
