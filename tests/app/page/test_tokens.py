"""Tokens: who may drive, who may only watch, and who has to wait."""

from __future__ import annotations

import asyncio
import json

import httpx
import pytest
from fastapi import FastAPI, Request, WebSocket
from hypothesis import given
from hypothesis import strategies as st
from starlette.responses import Response
from starlette.types import Message, Receive, Scope, Send

from app.page.access import SameOriginOnly
from app.page.token_guard import SUBPROTOCOL, TokenRequired, role_in
from app.page.token_guesses import FREE_GUESSES, LONGEST_WAIT, MOST_ADDRESSES, Guessing
from app.page.tokens import Role, Tokens, chosen_tokens
from robot.settings import SettingError

TOKENS = Tokens("drive-me", "watch-me")


class Clock:
    """Time that a test sets [s]."""

    def __init__(self) -> None:
        self.stamp = 0.0

    def __call__(self) -> float:
        return self.stamp


class Client:
    """Asks an application as a browser does, which keeps cookies."""

    def __init__(self, app: FastAPI, scheme: str = "http") -> None:
        self._app = app
        self._scheme = scheme
        self.cookies: dict[str, str] = {}

    def get(self, path: str, method: str = "GET", **headers: str) -> httpx.Response:
        """The answer to a request."""
        cookie = "; ".join(f"{name}={value}" for name, value in self.cookies.items())
        answer = asyncio.run(self._ask(path, method, {"cookie": cookie, **headers}))
        if "set-cookie" in answer.headers:
            name, _, value = answer.headers["set-cookie"].partition(";")[0].partition("=")
            self.cookies[name] = value
        return answer

    async def _ask(self, path: str, method: str, headers: dict[str, str]) -> httpx.Response:
        transport = httpx.ASGITransport(self._app, client=("10.0.0.1", 5000))
        base = f"{self._scheme}://robot.local:8080"
        async with httpx.AsyncClient(transport=transport, base_url=base) as client:
            return await client.request(method, path, headers=headers)

    def connect(self, path: str, subprotocols: list[str]) -> tuple[str | None, dict[str, object]]:
        """The subprotocol that is chosen for a socket, and its first message."""
        way, _, query = path.partition("?")
        scope = {
            "type": "websocket", "path": way, "query_string": query.encode(), "scheme": "ws",
            "headers": [], "subprotocols": subprotocols, "server": ("robot.local", 8080),
            "client": ("10.0.0.1", 5000), "root_path": "",
        }  # fmt: skip
        sent: list[Message] = []

        async def receive() -> Message:
            return {"type": "websocket.connect"}

        async def send(message: Message) -> None:
            sent.append(message)

        asyncio.run(self._app(scope, receive, send))
        if sent[0]["type"] == "websocket.close":
            raise ConnectionRefusedError(sent[0]["reason"])
        return sent[0].get("subprotocol"), json.loads(sent[1]["text"])


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def guarded(clock: Clock) -> FastAPI:
    app = FastAPI()
    app.add_middleware(TokenRequired, tokens=TOKENS, clock=clock)

    @app.get("/")
    @app.post("/")
    def page(request: Request) -> dict[str, str]:
        return {"role": role_in(request.scope).value}

    @app.post("/api/view/page/home")
    def look() -> None:
        pass

    @app.websocket("/live")
    async def live(socket: WebSocket) -> None:
        offered = socket.scope["subprotocols"]
        await socket.accept(offered[0] if offered else None)
        await socket.send_json({"role": role_in(socket.scope).value, "offered": offered})

    return app


@pytest.fixture
def client(guarded: FastAPI) -> Client:
    return Client(guarded)


# --- tokens


def test_tokens_drawn_at_random_differ_and_are_long() -> None:
    drawn = [Tokens.choose(None, None) for _ in range(50)]
    every = {token for tokens in drawn for token in (tokens.drive, tokens.watch)}
    assert len(every) == 100
    assert min(map(len, every)) >= 24


@pytest.mark.parametrize("token", ["", "short", "a b c d e f", "naïve-token", "x" * 101, "a;b=c/d"])
def test_a_token_that_a_link_or_cookie_cannot_hold_is_refused(token: str) -> None:
    with pytest.raises(SettingError, match="valid are 6 to 100 letters"):
        Tokens(token, "watch-me")


def test_one_token_for_both_is_refused() -> None:
    with pytest.raises(SettingError, match="choose two"):
        Tokens("the-same", "the-same")


@given(st.text(max_size=40))
def test_any_other_text_is_no_token(text: str) -> None:
    assert TOKENS.role_of(text) is {"drive-me": Role.DRIVE, "watch-me": Role.WATCH}.get(text)


@pytest.mark.parametrize("address", ["127.0.0.1", "127.8.8.8", "::1"])
def test_on_this_machine_alone_none_is_needed_but_one_can_be_asked_for(address: str) -> None:
    assert chosen_tokens(None, None, address, {}, refused=False) is None
    tokens = chosen_tokens("drive-me", None, address, {}, refused=False)
    assert tokens is not None
    assert tokens.drive == "drive-me"


@pytest.mark.parametrize("address", ["0.0.0.0", "::", "192.168.1.7"])
def test_elsewhere_one_is_drawn_unless_it_is_given_or_refused(address: str) -> None:
    assert chosen_tokens(None, None, address, {}, refused=False) is not None
    assert chosen_tokens(None, None, address, {}, refused=True) is None
    environment = {"BRICKPOSE_TOKEN": "from-outside", "BRICKPOSE_WATCH_TOKEN": "to-look-at"}
    assert chosen_tokens(None, None, address, environment, refused=False) == Tokens(
        "from-outside", "to-look-at"
    )


# --- requests


@pytest.mark.parametrize(("token", "role"), [("drive-me", "drive"), ("watch-me", "watch")])
def test_a_token_comes_in_a_header_or_a_link(client: Client, token: str, role: str) -> None:
    by_header = client.get("/", Authorization=f"Bearer {token}")
    by_link = client.get(f"/?token={token}")
    assert by_header.json() == by_link.json() == {"role": role}
    assert "set-cookie" not in by_header.headers


def test_a_link_sets_a_cookie_that_scripts_and_other_sites_cannot_use(client: Client) -> None:
    cookie = client.get("/?token=drive-me").headers["set-cookie"]
    assert cookie == "brickpose-8080=drive-me; HttpOnly; SameSite=Strict; Path=/"
    assert client.get("/").json() == {"role": "drive"}


def test_over_tls_the_cookie_is_sent_over_tls_alone(guarded: FastAPI) -> None:
    client = Client(guarded, "https")
    assert client.get("/?token=drive-me").headers["set-cookie"].endswith("; Secure")


def test_a_link_counts_more_than_the_cookie_but_takes_no_drive_away(client: Client) -> None:
    assert client.get("/?token=watch-me").json() == {"role": "watch"}
    assert client.get("/").json() == {"role": "watch"}
    client.get("/?token=drive-me")
    assert client.get("/").json() == {"role": "drive"}
    assert client.get("/?token=watch-me").json() == {"role": "watch"}
    assert client.get("/").json() == {"role": "drive"}  # anybody may send a link to watch
    assert client.cookies == {"brickpose-8080": "drive-me", "brickpose-8080-watch": "watch-me"}


def test_a_link_to_watch_from_another_site_takes_no_drive_away(client: Client) -> None:
    client.get("/?token=drive-me")
    kept = dict(client.cookies)
    client.cookies = {}  # a browser sends none with a navigation from another site
    site = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    client.get("/?token=watch-me", **site)
    client.cookies = kept | client.cookies
    assert client.get("/").json() == {"role": "drive"}


def test_a_wrong_link_sets_no_cookie(client: Client) -> None:
    client.cookies = {"brickpose-8080": "drive-me"}
    answer = client.get("/?token=evil%0d%0aX-Evil:1")
    assert answer.json() == {"role": "drive"}
    assert "set-cookie" not in answer.headers


def test_without_a_token_a_browser_gets_a_form_and_a_program_a_sentence(client: Client) -> None:
    page = client.get("/", Accept="text/html,*/*")
    assert (page.status_code, page.headers["content-type"]) == (401, "text/html; charset=utf-8")
    assert 'name="token"' in page.text
    assert 'name="token"' in client.get("/learn/3", Accept="text/html,*/*").text
    assert 'name="token"' not in client.get("/api/lessons/3", Accept="text/html,*/*").text
    sentence = client.get("/")
    assert sentence.status_code == 401
    assert sentence.headers["www-authenticate"].startswith("Bearer")
    assert "Authorization: Bearer" in sentence.text


def test_the_watch_token_reads_and_moves_its_own_view_only(client: Client) -> None:
    assert client.get("/api/view/page/home?token=watch-me", "POST").status_code == 200
    answer = client.get("/?token=watch-me", "POST")
    assert (answer.status_code, answer.text) == (403, "This token only watches.")
    assert client.get("/?token=drive-me", "POST").status_code == 200
    for method in ("PUT", "PATCH", "DELETE"):
        answer = client.get("/api/recordings/first?token=watch-me", method)
        assert (answer.status_code, answer.text) == (403, "This token only watches.")


# --- sockets


def test_a_socket_takes_the_token_as_a_subprotocol_and_chooses_it(client: Client) -> None:
    offered = [f"{SUBPROTOCOL}watch-me"]
    assert client.connect("/live", offered) == (offered[0], {"role": "watch", "offered": []})


def test_another_subprotocol_is_handed_on_and_wins(client: Client) -> None:
    offered = [f"{SUBPROTOCOL}drive-me", "viser-v1"]
    message = {"role": "drive", "offered": ["viser-v1"]}
    assert client.connect("/live", offered) == ("viser-v1", message)


@pytest.mark.parametrize("path", ["/live", "/live?token=wrong-one"])
def test_a_socket_without_a_token_is_refused(client: Client, path: str) -> None:
    with pytest.raises(ConnectionRefusedError, match="missing or wrong"):
        client.connect(path, [])


# --- places


def test_who_only_watches_waits_for_a_place_that_comes_free_and_who_drives_never_does() -> None:
    statuses = asyncio.run(statuses_with_one_place_to_watch())
    assert statuses == {"watch": 200, "second": 503, "drive": 200, "afterwards": 200}


async def statuses_with_one_place_to_watch() -> dict[str, int]:
    entered, leave = asyncio.Event(), asyncio.Event()

    async def answer_late(scope: Scope, receive: Receive, send: Send) -> None:
        entered.set()
        await leave.wait()
        await Response()(scope, receive, send)

    guard = TokenRequired(answer_late, TOKENS, most_watching=1)

    async def status(token: str) -> int:
        transport = httpx.ASGITransport(guard)
        async with httpx.AsyncClient(transport=transport, base_url="http://robot.local") as client:
            answer = await client.get("/", headers={"Authorization": f"Bearer {token}"})
        return answer.status_code

    async with asyncio.timeout(20), asyncio.TaskGroup() as tasks:
        watch = tasks.create_task(status(TOKENS.watch))
        await entered.wait()
        second = await status(TOKENS.watch)
        entered.clear()
        drive = tasks.create_task(status(TOKENS.drive))
        await entered.wait()  # while the only place to watch is taken
        leave.set()
    return {
        "watch": watch.result(),
        "second": second,
        "drive": drive.result(),
        "afterwards": await status(TOKENS.watch),
    }


# --- guessing


def test_who_guesses_waits_longer_and_longer(client: Client, clock: Clock) -> None:
    for guess in range(FREE_GUESSES + 1):
        assert client.get(f"/?token=guess-{guess}").status_code == 401
    answer = client.get("/?token=one-more")
    assert (answer.status_code, answer.headers["retry-after"]) == (429, "2")
    assert client.get("/").status_code == 401  # no guess
    clock.stamp = 1.1
    assert client.get("/?token=another").status_code == 401
    clock.stamp = 2.2
    assert client.get("/?token=yet-another").status_code == 429
    clock.stamp = 3.2
    assert client.get("/?token=the-next").status_code == 401


def test_a_right_token_passes_at_once_whoever_guesses_from_its_address(guarded: FastAPI) -> None:
    for guess in range(60):
        wrong = Client(guarded).get(f"/?token=guess-{guess}")
        assert wrong.status_code == (401 if guess <= FREE_GUESSES else 429)
        for token in ("drive-me", "watch-me"):
            assert Client(guarded).get(f"/?token={token}").status_code == 200
            by_header = Client(guarded).get("/", Authorization=f"Bearer {token}")
            assert by_header.status_code == 200
        offered = [f"{SUBPROTOCOL}drive-me"]
        assert Client(guarded).connect("/live", offered)[1]["role"] == "drive"


def test_a_right_token_forgives_no_wrong_ones(guarded: FastAPI) -> None:
    for guess in range(FREE_GUESSES + 1):
        assert Client(guarded).get(f"/?token=guess-{guess}").status_code == 401
        assert Client(guarded).get("/?token=drive-me").status_code == 200
    assert Client(guarded).get("/?token=guess-more").status_code == 429


FRAMES = ["iframe", "frame", "embed", "object", "fencedframe"]
SITES = ["cross-site", "same-site"]


@pytest.mark.parametrize("site", SITES)
@pytest.mark.parametrize("dest", FRAMES)
def test_a_frame_of_another_site_never_reaches_the_guard(
    guarded: FastAPI, site: str, dest: str
) -> None:
    guarded.add_middleware(SameOriginOnly, names=frozenset(["robot.local"]))
    client = Client(guarded)
    frame = {"sec-fetch-site": site, "sec-fetch-mode": "navigate", "sec-fetch-dest": dest}
    for guess in range(3 * FREE_GUESSES):
        assert client.get(f"/?token=wrong-{guess}", **frame).status_code == 403
    assert client.get("/?token=drive-me", **frame).status_code == 403
    assert not client.cookies
    assert client.get("/?token=mistyped").status_code == 401  # nothing was counted


@pytest.mark.parametrize("site", SITES)
def test_a_link_on_another_site_opens_the_page_and_a_wrong_one_costs_its_user_nothing(
    guarded: FastAPI, site: str
) -> None:
    guarded.add_middleware(SameOriginOnly, names=frozenset(["robot.local"]))
    link = {"sec-fetch-site": site, "sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
    for guess in range(FREE_GUESSES + 1):
        assert Client(guarded).get(f"/?token=wrong-{guess}", **link).status_code == 401
    assert Client(guarded).get("/?token=one-more", **link).status_code == 429
    assert Client(guarded).get("/?token=mistyped").status_code == 401
    assert Client(guarded).get("/?token=drive-me", **link).json() == {"role": "drive"}


def test_the_pages_own_frames_are_shown(guarded: FastAPI) -> None:
    guarded.add_middleware(SameOriginOnly, names=frozenset(["robot.local"]))
    own = {
        "sec-fetch-site": "same-origin",
        "sec-fetch-mode": "navigate",
        "sec-fetch-dest": "iframe",
    }
    assert Client(guarded).get("/?token=drive-me", **own).status_code == 200


def test_a_foreign_page_that_guesses_lets_nobody_wait_but_foreign_pages(guarded: FastAPI) -> None:
    names = frozenset(["robot.local"])
    guarded.add_middleware(SameOriginOnly, names=names, inviting=frozenset(["/"]))
    client = Client(guarded)
    for number in range(FREE_GUESSES + 2):
        answer = client.get(f"/?token=wrong-{number}", origin="https://evil.example")
    assert answer.status_code == 429
    assert client.get("/?token=mistyped").status_code == 401
    assert client.get("/?token=drive-me").status_code == 200


def test_an_old_page_that_reconnects_is_no_guess() -> None:
    guessing = Guessing()
    for stamp in range(100):
        guessing.wrong("10.0.0.1", "of-the-last-run", float(stamp))
    assert guessing.wait("10.0.0.1", 100.0) == 0


@given(st.lists(st.tuples(st.sampled_from(["a", "b"]), st.integers(0, 9)), max_size=60))
def test_addresses_wait_by_themselves_and_never_longer_than_a_minute(guesses) -> None:
    both, alone = Guessing(), Guessing()
    for stamp, (address, token) in enumerate(guesses):
        both.wrong(address, str(token), float(stamp))
        if address == "a":
            alone.wrong(address, str(token), float(stamp))
        assert both.wait("a", float(stamp)) == alone.wait("a", float(stamp)) <= LONGEST_WAIT


def test_no_more_addresses_than_these_are_remembered() -> None:
    guessing = Guessing()
    for number in range(MOST_ADDRESSES + 10):
        for guess in range(FREE_GUESSES + 1):
            guessing.wrong(str(number), str(guess), 0.0)
    assert guessing.wait("9", 0.0) == 0
    assert guessing.wait("10", 0.0) > 0
