"""ClassDesk: at a student's own server, what the teacher's wall orders, and a raised hand.

While a student is frozen, their pages only watch: their sockets are closed and come back as those
of watchers, which stops what they drove. The teacher, who is no owner, still drives.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from app.features.classroom.sign_in import VISITOR
from app.features.classroom.sleep import Sleeper
from app.features.classroom.told_sockets import ToldSockets
from app.languages.marking import phrase
from app.page.token_guard import CODE, WHY
from app.page.tokens import Role

ADDRESS = "classroom"
LONGEST_MESSAGE = 500
LONGEST_BODY = 10_000
ROLE = "brickpose.role"
FROZEN = phrase("The teacher has frozen all robots.")

P = TypeVar("P", bound=BaseModel)


class Order(BaseModel):
    """What the teacher orders; what is left out stays."""

    model_config = ConfigDict(extra="forbid")
    frozen: bool | None = None
    message: str | None = Field(None, max_length=LONGEST_MESSAGE)
    """Shown on the student's pages; empty takes it away."""
    lesson: int | None = Field(None, ge=0, le=999)
    """The page has a link to it; 0 takes it away."""


class Hand(BaseModel):
    """What a student says."""

    model_config = ConfigDict(extra="forbid")
    hand: bool


@dataclass
class ClassState:
    """What holds for a student now."""

    frozen: bool = False
    message: str = ""
    lesson: int = 0
    """That was handed out; 0 is none."""
    hand: bool = False
    ended: str = ""
    """Why the server before this one was ended, in words."""
    owner: str = ""
    sockets: ToldSockets = field(default_factory=ToldSockets)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {
            "frozen": self.frozen, "message": self.message, "lesson": self.lesson,
            "hand": self.hand, "ended": self.ended,
        }  # fmt: skip

    def obey(self, order: Order) -> None:
        """Carry out an order."""
        if order.message is not None:
            self.message = order.message
        if order.lesson is not None:
            self.lesson = order.lesson
        if order.frozen is not None and order.frozen != self.frozen:
            self.frozen = order.frozen
            self.sockets.tell(self.owner)


class ClassDesk:
    """Stands between the sign-in and the student's server."""

    def __init__(
        self, app: ASGIApp, owner: str, prefix: str, state: ClassState, sleeper: Sleeper
    ) -> None:
        """Keep a desk for ``owner``, whose server is below ``prefix``."""
        self._sleeper = sleeper
        self._app = app
        self._owner = owner
        self._path = f"{prefix}{ADDRESS}"
        self._state = state
        state.owner = owner

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what is for the desk; pass on all else with what its sender may do."""
        if VISITOR not in scope:
            try:
                await self._app(scope, receive, send)
            finally:
                self._sleeper.wake()  # it has to hear that the server ends
            return
        owns = scope[VISITOR].name == self._owner
        if scope["type"] == "http" and scope["path"] == self._path:
            await (await self._answer(Request(scope, receive), owns=owns))(scope, receive, send)
            return
        if scope[VISITOR].is_service:
            await self._app({**scope, CODE: False}, receive, send)
            return
        with self._sleeper.looked():
            await self._pass(scope, receive, send, owns=owns)

    async def _pass(self, scope: Scope, receive: Receive, send: Send, *, owns: bool) -> None:
        frozen = owns and self._state.frozen
        scope = {**scope, CODE: owns and not frozen, ROLE: Role.WATCH if frozen else Role.DRIVE}
        if frozen:
            scope[WHY] = FROZEN
        if scope["type"] == "websocket" and owns:
            await self._state.sockets.serve(self._owner, self._app, scope, receive, send)
        elif frozen and scope["method"] not in ("GET", "HEAD"):
            await PlainTextResponse(FROZEN, 403)(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _answer(self, request: Request, *, owns: bool) -> Response:
        if request.method == "GET":
            shown = self._state.to_json() | {"asleep": self._sleeper.asleep}
            return JSONResponse(shown, headers={"Cache-Control": "no-store"})
        said = await (posted(request, Hand) if owns else posted(request, Order))
        if isinstance(said, Response):
            return said
        if isinstance(said, Hand):
            self._state.hand = said.hand
        else:
            self._state.obey(said)
        return JSONResponse(self._state.to_json())


async def posted(request: Request, kind: type[P]) -> P | Response:
    """Return what was posted, or the answer that refuses it."""
    if request.method != "POST":
        return PlainTextResponse("valid are GET and POST", 405)
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > LONGEST_BODY:
            return PlainTextResponse("that is too long", 413)
    try:
        return kind.model_validate_json(body)
    except ValidationError as error:
        return JSONResponse({"detail": json.loads(error.json())}, 422)
