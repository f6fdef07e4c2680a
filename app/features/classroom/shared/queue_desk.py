"""QueueDesk: at a robot that a class shares, lets one drive after the other."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from app.features.classroom.class_desk import ROLE, posted
from app.features.classroom.hub_client import Visitor
from app.features.classroom.roster import TEACHER
from app.features.classroom.shared.turns import TurnQueue
from app.features.classroom.sign_in import VISITOR
from app.features.classroom.told_sockets import ToldSockets
from app.languages.marking import phrase
from app.page.token_guard import CODE, WHY
from app.page.tokens import Role

ADDRESS = "queue"
LOOK_S = 0.5
"""A turn ends so much late at most [s]."""
NOT_NOW = phrase("It is not your turn: queue up first.")
TEACHERS = ("skip", "hand", "end", "open")


class QueueWish(BaseModel):
    """What somebody wants of the queue; all but ``join`` and ``leave`` are the teacher's."""

    model_config = ConfigDict(extra="forbid")
    action: Literal["join", "leave", "skip", "hand", "end", "open"]
    login: str = ""
    """Who gets the turn, if it is handed over."""


class QueueDesk:
    """Stands between the sign-in and the shared robot's server."""

    def __init__(self, app: ASGIApp, prefix: str, turns: TurnQueue) -> None:
        """Keep the queue of a robot that is served below ``prefix``."""
        self._app = app
        self._path = f"{prefix}{ADDRESS}"
        self._turns = turns
        self._sockets = ToldSockets()
        self._driver: str | None = None
        self._watch: asyncio.Task[None] | None = None

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what is for the queue; pass on all else with what its sender may do now."""
        if VISITOR not in scope:
            await self._app(scope, receive, send)
            return
        if self._watch is None:
            self._watch = asyncio.get_running_loop().create_task(self._keep_turns())
        visitor: Visitor = scope[VISITOR]
        if scope["type"] == "http" and scope["path"] == self._path:
            await (await self._answer(Request(scope, receive), visitor))(scope, receive, send)
            return
        self._pass_on()
        drives = visitor.name == self._turns.driver or _teaches(visitor)
        role = Role.DRIVE if drives else Role.WATCH
        scope = {**scope, CODE: False, ROLE: role}
        if not drives:
            scope[WHY] = NOT_NOW
        if scope["type"] == "websocket":
            await self._sockets.serve(visitor.name, self._app, scope, receive, send)
        elif role is Role.WATCH and scope["method"] not in ("GET", "HEAD"):
            await PlainTextResponse(NOT_NOW, 403)(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _answer(self, request: Request, visitor: Visitor) -> Response:
        if request.method == "GET":
            return self._shown_to(visitor)
        wish = await posted(request, QueueWish)
        if isinstance(wish, Response):
            return wish
        if wish.action in TEACHERS and not _teaches(visitor):
            return PlainTextResponse("Only the teacher does that.", 403)
        self._carry_out(wish, visitor.name)
        return self._shown_to(visitor)

    def _carry_out(self, wish: QueueWish, name: str) -> None:
        turns = self._turns
        match wish.action:
            case "join":
                turns.join(name)
            case "leave":
                turns.leave(name)
            case "skip":
                turns.skip()
            case "hand":
                turns.hand_to(wish.login)
            case "end" | "open":
                turns.end(ended=wish.action == "end")
        self._pass_on()

    def _shown_to(self, visitor: Visitor) -> JSONResponse:
        own: dict[str, Any] = {"me": visitor.name, "teaches": _teaches(visitor)}
        answer = self._turns.to_json() | own
        return JSONResponse(answer, headers={"Cache-Control": "no-store"})

    async def _keep_turns(self) -> None:
        with suppress(asyncio.CancelledError):
            while True:
                await asyncio.sleep(LOOK_S)
                self._pass_on()

    def _pass_on(self) -> None:
        """Look whose turn it is; tell who drives no more, and who drives from now on."""
        self._turns.look()
        before, self._driver = self._driver, self._turns.driver
        if before != self._driver:
            for name in filter(None, (before, self._driver)):
                self._sockets.tell(name)


def _teaches(visitor: Visitor) -> bool:
    return visitor.name == TEACHER or visitor.is_service
