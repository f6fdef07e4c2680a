"""The sign-in before a student's server, with a hub that behaves as JupyterHub does."""

from __future__ import annotations

import asyncio
import base64
import hashlib
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from starlette.requests import Request
from starlette.responses import JSONResponse

from app.features.classroom.class_desk import ClassDesk, ClassState
from app.features.classroom.hub_client import HubEnvironment, HubError, Visitor
from app.features.classroom.sign_in import CHECK_S, SESSION, STATE, VISITOR, Sessions, SignIn
from app.features.classroom.sleep import Sleeper
from app.page.token_guard import WHY, may_run_code, role_in
from robot.settings import SettingError

PREFIX = "/user/ada/"
VARIABLES = {
    "JUPYTERHUB_API_URL": "http://127.0.0.1:1/hub/api",
    "JUPYTERHUB_API_TOKEN": "of-the-server",
    "JUPYTERHUB_CLIENT_ID": "jupyterhub-user-ada",
    "JUPYTERHUB_SERVICE_PREFIX": PREFIX,
    "JUPYTERHUB_SERVICE_URL": "http://127.0.0.1:5000/user/ada/",
    "JUPYTERHUB_OAUTH_CALLBACK_URL": f"{PREFIX}oauth_callback",
    "JUPYTERHUB_OAUTH_ACCESS_SCOPES": '["access:servers!server=ada/", "access:servers!user=ada"]',
    "JUPYTERHUB_BASE_URL": "/",
    "JUPYTERHUB_USER": "ada",
}
OWN = frozenset({"access:servers!server=ada/"})
PEOPLE = {
    "ada's": Visitor("ada", OWN),
    "bo's": Visitor("bo", frozenset({"access:servers!user=bo"})),
    "the teacher's": Visitor("teacher", OWN | {"admin:users"}),
    "the wall's": Visitor("wall", frozenset({"access:servers"}), is_service=True),
}


class FakeHub:
    """Knows people by tokens, and gives a token for a code to who has its verifier."""

    def __init__(self) -> None:
        self.environment = HubEnvironment.of(VARIABLES)
        self.people = dict(PEOPLE)
        self.codes: dict[str, tuple[str, str]] = {}
        self.asked = 0
        self.answers = True

    def visitor(self, token: str) -> Visitor | None:
        if not self.answers:
            raise HubError(0, "the hub does not answer")
        self.asked += 1
        return self.people.get(token)

    def token_of(self, code: str, verifier: str) -> str:
        token, challenge = self.codes.pop(code, ("", ""))
        digest = base64.urlsafe_b64encode(hashlib.sha256(verifier.encode()).digest())
        if digest.rstrip(b"=").decode() != challenge:
            raise HubError(400, "invalid_grant")
        return token


class Browser:
    """Keeps cookies, and follows no redirect by itself."""

    def __init__(self, app) -> None:
        transport = httpx.ASGITransport(app, client=("127.0.0.1", 1))
        self.client = httpx.AsyncClient(transport=transport, base_url="http://school.example:8000")

    def ask(self, path: str, method: str = "GET", **given) -> httpx.Response:
        return asyncio.run(self.client.request(method, path, **given))

    def open(self, path: str) -> httpx.Response:
        return self.ask(path, headers={"accept": "text/html"})

    def sign_in(self, hub: FakeHub, token: str, path: str = f"{PREFIX}learn/1") -> httpx.Response:
        sent = self.open(path)
        query = parse_qs(urlsplit(sent.headers["location"]).query)
        hub.codes["a-code"] = token, query["code_challenge"][0]
        return self.open(f"{PREFIX}oauth_callback?code=a-code&state={query['state'][0]}")


class Clock:
    stamp = 0.0

    def __call__(self) -> float:
        return self.stamp


@pytest.fixture
def hub():
    return FakeHub()


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def state():
    return ClassState()


@pytest.fixture
def app(hub, clock, state):
    async def server(scope, receive, send):
        told = {
            "who": scope[VISITOR].name, "role": role_in(scope).value, "why": scope.get(WHY),
            "code": may_run_code(scope), "host": Request(scope).headers["host"],
            "origin": Request(scope).headers.get("origin"),
        }  # fmt: skip
        await JSONResponse(told)(scope, receive, send)

    desk = ClassDesk(server, owner="ada", prefix=PREFIX, state=state, sleeper=Sleeper())
    return SignIn(desk, hub, Sessions(clock))


@pytest.fixture
def browser(app):
    return Browser(app)


def test_a_browser_signs_in_and_comes_back_to_the_page_that_it_asked_for(browser, hub):
    sent = browser.open(f"{PREFIX}learn/3?x=1")
    place = urlsplit(sent.headers["location"])
    assert (sent.status_code, place.path) == (302, "/hub/api/oauth2/authorize")
    query = {key: value[0] for key, value in parse_qs(place.query).items()}
    assert query["client_id"] == "jupyterhub-user-ada"
    assert query["redirect_uri"] == f"{PREFIX}oauth_callback"
    back = browser.sign_in(hub, "ada's", f"{PREFIX}learn/3?x=1")
    assert back.headers["location"] == f"{PREFIX}learn/3?x=1"
    cookie = next(c for c in browser.client.cookies.jar if c.name == SESSION)
    assert cookie.path == PREFIX
    assert "HttpOnly" in cookie._rest
    told = browser.open(f"{PREFIX}learn/3").json()
    assert told == {
        "who": "ada",
        "role": "drive",
        "why": None,
        "code": True,
        "host": "localhost",
        "origin": None,
    }


def test_nobody_is_led_to_another_site(browser, hub):
    assert browser.sign_in(hub, "ada's", "//evil.example/x").headers["location"] == PREFIX


def test_another_student_is_refused_and_who_only_asks_is_not_sent_away(browser, hub):
    assert browser.ask(f"{PREFIX}api/state").status_code == 401
    browser.sign_in(hub, "bo's")
    answer = browser.open(PREFIX)
    assert (answer.status_code, "not the robot of bo" in answer.text) == (403, True)


@pytest.mark.parametrize("token", ["the teacher's", "the wall's"])
def test_teacher_and_wall_drive_but_run_no_code(browser, token):
    told = browser.ask(PREFIX, headers={"Authorization": f"token {token}"}).json()
    assert (told["role"], told["code"]) == ("drive", False)


def test_a_code_that_another_page_sends_along_signs_nobody_in(browser, hub):
    hub.codes["a-code"] = "bo's", "a challenge"
    answer = browser.open(f"{PREFIX}oauth_callback?code=a-code&state=guessed")
    assert (answer.status_code, answer.headers["location"]) == (302, PREFIX)
    assert SESSION not in browser.client.cookies
    sent = browser.open(PREFIX)
    mine = parse_qs(urlsplit(sent.headers["location"]).query)["state"][0]
    browser.client.cookies.delete(STATE)
    browser.open(f"{PREFIX}oauth_callback?code=a-code&state={mine}")
    assert SESSION not in browser.client.cookies


def test_a_sign_out_is_heard_and_the_hub_is_not_asked_each_time(browser, hub, clock):
    browser.sign_in(hub, "ada's")
    asked = hub.asked
    for _ in range(5):
        assert browser.open(PREFIX).status_code == 200
    assert hub.asked == asked
    del hub.people["ada's"]
    clock.stamp += CHECK_S
    assert browser.open(PREFIX).status_code == 302


def test_who_has_signed_in_goes_on_while_the_hub_is_begun_again(browser, hub, clock):
    browser.sign_in(hub, "ada's")
    hub.answers = False
    clock.stamp += CHECK_S
    assert browser.open(PREFIX).status_code == 200
    hub.answers = True
    del hub.people["ada's"]
    assert browser.open(PREFIX).status_code == 302, "it is asked again as soon as it is there"


def test_a_hub_that_does_not_answer_lets_nobody_new_in(browser, hub):
    hub.answers = False
    answer = browser.ask(PREFIX, headers={"Authorization": "token ada's"})
    assert (answer.status_code, "try again" in answer.text) == (503, True)


def test_pages_of_other_sites_stay_such(browser, hub):
    browser.sign_in(hub, "ada's")
    own = browser.ask(PREFIX, headers={"origin": "http://school.example:8000"}).json()
    other = browser.ask(PREFIX, headers={"origin": "http://evil.example"}).json()
    assert (own["origin"], other["origin"]) == ("http://localhost", "http://evil.example")


def test_a_start_without_a_hub_is_refused_with_what_is_valid():
    with pytest.raises(SettingError, match="JUPYTERHUB_API_URL is not in the environment: valid"):
        HubEnvironment.of({})


WALL = {"Authorization": "token the wall's"}
ADA = {"Authorization": "token ada's"}


def test_a_frozen_student_only_watches_and_the_teacher_still_drives(browser, state):
    answer = browser.ask(f"{PREFIX}classroom", "POST", headers=WALL, json={"frozen": True})
    assert answer.json() == {
        "frozen": True, "message": "", "lesson": 0, "hand": False, "ended": "",
    }  # fmt: skip
    told = browser.ask(PREFIX, headers=ADA).json()
    assert (told["role"], told["code"]) == ("watch", False)
    assert told["why"] == "The teacher has frozen all robots."
    assert browser.ask(f"{PREFIX}api/student_file", "PUT", headers=ADA).status_code == 403
    assert browser.ask(PREFIX, headers=WALL).json()["role"] == "drive"
    browser.ask(f"{PREFIX}classroom", "POST", headers=WALL, json={"frozen": False})
    assert browser.ask(PREFIX, headers=ADA).json()["role"] == "drive"


def test_a_student_raises_a_hand_and_gives_no_orders(browser, state):
    assert browser.ask(f"{PREFIX}classroom", "POST", headers=ADA, json={"hand": True}).json()[
        "hand"
    ]
    for wrong in ({"frozen": False}, {"message": "all go home"}, {}):
        answer = browser.ask(f"{PREFIX}classroom", "POST", headers=ADA, json=wrong)
        assert answer.status_code == 422
    assert (state.frozen, state.message) == (False, "")


@pytest.mark.parametrize(
    ("order", "status"),
    [({"message": "x" * 501}, 422), ({"shut": 1}, 422), ({"message": "x" * 10_001}, 413)],
)
def test_a_wrong_order_is_refused(browser, order, status):
    answer = browser.ask(f"{PREFIX}classroom", "POST", headers=WALL, json=order)
    assert answer.status_code == status


def test_who_is_frozen_loses_open_sockets_so_that_they_come_back_as_watchers(hub, clock, state):
    sent: list[dict] = []

    async def server(scope, receive, send):
        await send({"type": "websocket.accept"})
        await asyncio.Event().wait()

    async def run() -> None:
        desk = ClassDesk(server, owner="ada", prefix=PREFIX, state=state, sleeper=Sleeper())
        app = SignIn(desk, hub, Sessions(clock))
        accepted = asyncio.Event()

        async def send(message) -> None:
            sent.append(message)
            accepted.set()

        scope = {
            "type": "websocket", "path": f"{PREFIX}api/live", "query_string": b"", "scheme": "ws",
            "headers": [(b"authorization", b"token ada's"), (b"host", b"school.example")],
        }  # fmt: skip
        serving = asyncio.create_task(app(scope, asyncio.Event().wait, send))
        await asyncio.wait_for(accepted.wait(), 20)
        from app.features.classroom.class_desk import Order

        state.obey(Order(frozen=True))
        await asyncio.wait_for(serving, 20)

    asyncio.run(run())
    assert [message["type"] for message in sent] == ["websocket.accept", "websocket.close"]
