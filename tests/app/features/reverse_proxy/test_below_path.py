"""Requests below a path: which are ours, what the application sees, and what is refused."""

from __future__ import annotations

import asyncio
from urllib.parse import quote

import httpx
import pytest
from fastapi import FastAPI, Request
from hypothesis import given
from hypothesis import strategies as st
from starlette.middleware import Middleware

from app.features.reverse_proxy import jupyter
from app.features.reverse_proxy.below_path import BelowPath
from app.features.reverse_proxy.own_name import KnownProxy, under_own_name
from app.features.reverse_proxy.settings import ReverseProxySettings
from app.page.access import SameOriginOnly
from app.page.token_guard import TokenRequired
from app.page.tokens import Tokens
from app.settings.config import Config
from robot.settings import SettingError

TOKENS = Tokens("drive-me", "watch-me")


def application(*gates: Middleware) -> FastAPI:
    app = FastAPI(middleware=[*reversed(gates)])

    @app.get("/api/state")
    def state(request: Request) -> dict[str, str]:
        return {"root": request.scope["root_path"], "address": str(request.url)}

    return app


def get(app: FastAPI, address: str, **headers: str) -> httpx.Response:
    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost:80") as client:
            return await client.get(address, headers=headers)

    return asyncio.run(ask())


@pytest.mark.parametrize("path", ["/user/jürgen/robot/api/state", "/api/state"])
def test_a_path_that_the_proxy_keeps_or_takes_away_is_found(path):
    root = ReverseProxySettings("/user/j%C3%BCrgen/robot/").root
    answer = get(application(Middleware(BelowPath, root=root)), quote(path))
    assert answer.json() == {
        "root": "/user/jürgen/robot",
        "address": "http://localhost/user/jürgen/robot/api/state",
    }


def test_the_path_without_its_last_slash_leads_to_that_with_it_whatever_the_proxy_is_called():
    app = application(Middleware(BelowPath, root="/user/ada"))
    answer = get(app, "/user/ada?token=drive-me")
    assert (answer.status_code, answer.headers["location"]) == (307, "./ada/?token=drive-me")
    assert get(app, "/user/adam/api/state").status_code == 404


def test_a_cookie_is_confined_to_the_path_and_a_person_is_asked_for_a_token_there():
    app = application(
        Middleware(TokenRequired, tokens=TOKENS), Middleware(BelowPath, root="/user/jürgen")
    )
    cookie = get(app, "/api/state?token=drive-me").headers["set-cookie"]
    assert cookie.endswith("; Path=/user/j%C3%BCrgen/")
    asked = get(app, "/user/j%C3%BCrgen/lens", accept="text/html")
    assert (asked.status_code, "asks for a token" in asked.text) == (401, True)


@pytest.mark.parametrize(
    "wrong", ["user/ada", "//evil.example/", "/a/../b", "/a b", "/a?b", "/a;\n"]
)
def test_a_wrong_path_is_refused_with_one_that_is_valid(wrong):
    with pytest.raises(SettingError, match="valid is a path such as /user/ada/brickpose/"):
        ReverseProxySettings(wrong)


@given(st.text(st.characters(categories=["L", "N"]), min_size=1, max_size=8))
def test_any_name_of_a_user_can_be_in_the_path(name):
    assert ReverseProxySettings(f"/user/{quote(name)}/").root == f"/user/{name}"


def known(token: str = "drive-me") -> FastAPI:
    return application(
        Middleware(SameOriginOnly, names=frozenset({"localhost"})),
        Middleware(KnownProxy, token="drive-me"),
    )


@pytest.mark.parametrize(
    ("bearer", "origin", "status"),
    [
        ("drive-me", "http://school.example", 200),
        ("drive-me", "http://evil.example", 403),
        ("drive-me", "http://[", 403),
        ("guessed", "http://school.example", 403),
    ],
)
def test_who_brings_the_token_may_call_the_server_by_any_name_but_not_from_other_sites(
    bearer, origin, status
):
    headers = {"host": "school.example", "origin": origin, "authorization": f"Bearer {bearer}"}
    assert get(known(), "/api/state", **headers).status_code == status


def test_headers_of_the_given_request_stay_as_they_are():
    scope = {"type": "http", "headers": [(b"host", b"school.example")]}
    assert under_own_name(scope)["headers"] == [(b"host", b"localhost")]
    assert scope["headers"] == [(b"host", b"school.example")]


def test_jupyters_proxy_starts_a_program_that_only_it_can_ask():
    first, second = jupyter.server(), jupyter.server()
    assert first["command"][-4:] == [
        "{port}",
        "--root-path",
        "{base_url}brickpose/",
        "--allow-code",
    ]
    token = first["environment"]["BRICKPOSE_TOKEN"]
    assert first["request_headers_override"] == {"Authorization": f"Bearer {token}"}
    assert token != second["environment"]["BRICKPOSE_TOKEN"]
    assert Config().group("reverse_proxy", ReverseProxySettings()).root == ""
