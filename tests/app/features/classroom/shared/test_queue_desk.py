"""A robot that a class shares: whose turn it is drives, the others watch, the teacher decides."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from starlette.requests import Request
from starlette.responses import JSONResponse

from app.features.classroom.hub_client import Visitor
from app.features.classroom.shared.queue_desk import QueueDesk
from app.features.classroom.shared.turns import TurnQueue
from app.features.classroom.sign_in import VISITOR
from app.page.token_guard import WHY, may_run_code, role_in

PREFIX = "/services/robot/"


@pytest.fixture
def ask():
    """Asks the shared robot's server as somebody."""

    async def inner(scope, receive, send):
        request = Request(scope)
        told = {"role": role_in(scope).name, "code": may_run_code(scope), "why": scope.get(WHY)}
        await JSONResponse(told | {"method": request.method})(scope, receive, send)

    desk = QueueDesk(inner, PREFIX, TurnQueue(60.0))

    def ask(name: str, method: str = "GET", path: str = "api/state", **wish: str):
        async def signed_in(scope, receive, send):
            visitor = Visitor(name, frozenset(), name == "wall")
            await desk({**scope, VISITOR: visitor}, receive, send)

        async def run():
            transport = httpx.ASGITransport(signed_in)
            async with httpx.AsyncClient(transport=transport, base_url="http://x") as client:
                return await client.request(method, PREFIX + path, json=wish or None)

        desk._watch = None  # each request here has an event loop of its own
        return asyncio.run(run())

    return ask


def wish(ask, name: str, action: str, **more: str):
    return ask(name, "POST", "queue", action=action, **more)


def test_only_whose_turn_it_is_drives(ask):
    assert wish(ask, "ada", "join").json()["driver"] == "ada"
    assert wish(ask, "bo", "join").json()["waiting"] == ["bo"]
    assert ask("ada").json()["role"] == "DRIVE"
    assert ask("bo").json()["role"] == "WATCH"
    assert ask("bo").json()["why"] == "It is not your turn: queue up first."
    assert ask("ada").json()["why"] is None
    assert ask("teacher").json()["role"] == "DRIVE"
    assert ask("ada", "POST").json()["method"] == "POST"
    assert ask("bo", "POST").status_code == 403
    wish(ask, "ada", "leave")
    assert ask("bo").json()["role"] == "DRIVE"
    assert ask("ada").json()["role"] == "WATCH"


def test_nobodys_code_runs_at_the_shared_robot(ask):
    wish(ask, "ada", "join")
    assert [ask(name).json()["code"] for name in ("ada", "bo", "teacher")] == [False] * 3


def test_only_the_teacher_hands_over_skips_and_ends(ask):
    for name in ("ada", "bo"):
        wish(ask, name, "join")
    for action in ("skip", "hand", "end", "open"):
        assert wish(ask, "ada", action, login="bo").status_code == 403
    assert wish(ask, "teacher", "hand", login="bo").json()["driver"] == "bo"
    assert wish(ask, "wall", "skip").json()["driver"] == "ada"
    ended = wish(ask, "wall", "end").json()
    assert (ended["driver"], ended["waiting"], ended["ended"]) == (None, [], True)
    assert ask("ada").json()["role"] == "WATCH"


@pytest.mark.parametrize("body", [{}, {"action": "drive"}, {"action": "join", "more": "x"}])
def test_a_wrong_wish_is_refused(ask, body):
    assert ask("ada", "POST", "queue", **body).status_code == 422
