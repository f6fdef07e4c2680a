"""A program that asks for a token: what strangers send costs its driver nothing."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from http.client import HTTPConnection
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from serving import started
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.page.token_guesses import FREE_GUESSES

pytestmark = pytest.mark.slow

DRIVE, WATCH = "drive-me-please", "watch-me-only"
ACCESS = ("--robot", "kinematic", "--map", "stub", "--port", "0", "--token", DRIVE,
          "--watch-token", WATCH)  # fmt: skip
SAYS = r"BrickPose is at http://127\.0\.0\.1:(\d+)"


@contextmanager
def at(*options: str) -> Iterator[int]:
    """Start a program; yield its port once it drives."""
    with started("run", *ACCESS, *options, says=SAYS) as (_, port):
        while not _drives(int(port)):
            time.sleep(0.2)
        yield int(port)


def _drives(port: int) -> bool:
    """Whether there is a robot: at the very first start the program compiles before."""
    try:
        return status(port, "/api/state", Authorization=f"Bearer {DRIVE}") == 200
    except OSError:  # between the page that says so and the program
        return False


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with at() as own:
        yield own


@pytest.fixture(scope="module")
def proxied() -> Iterator[int]:
    """The port of a program that believes a proxy on this computer."""
    with at("--forwarded-allow-ips", "127.0.0.1", "--allow-code") as own:
        yield own


def status(port: int, path: str, **headers: str) -> int:
    """How the program answers."""
    connection = HTTPConnection("127.0.0.1", port, timeout=30)
    try:
        connection.request("GET", path, headers=headers)
        return connection.getresponse().status
    finally:
        connection.close()


def guess(port: int, number: int, **headers: str) -> int:
    return status(port, f"/?token=wrong-{number}", **headers)


def live(port: int, token: str, **options: float):
    address = f"ws://127.0.0.1:{port}/api/live?token={token}"
    return connect(address, open_timeout=30, **options)


def test_the_driver_comes_in_while_somebody_guesses_at_the_same_address(port: int) -> None:
    for number in range(60):
        assert guess(port, number) in (401, 429)
        assert status(port, f"/?token={DRIVE}") == 200
        assert status(port, "/api/health", Authorization=f"Bearer {WATCH}") == 200
    # The first may come when a wait has just ended; the next wait has begun with it.
    assert 429 in (guess(port, 1000), guess(port, 1001))
    with live(port, DRIVE) as socket:
        assert json.loads(socket.recv(timeout=30))["type"] == "telemetry"


def test_what_a_stranger_says_of_its_address_is_not_believed(port: int) -> None:
    said = [guess(port, n, **{"X-Forwarded-For": f"10.0.0.{n}"}) for n in range(FREE_GUESSES + 3)]
    assert 429 in said[FREE_GUESSES:]


def test_a_proxy_that_is_named_is_believed(proxied: int) -> None:
    for number in range(FREE_GUESSES + 3):
        said = guess(proxied, number, **{"X-Forwarded-For": f"10.0.0.{number}"})
        assert said == 401
    said = [guess(proxied, n, **{"X-Forwarded-For": "10.9.9.9"}) for n in range(FREE_GUESSES + 3)]
    assert 429 in said[FREE_GUESSES:]


def answer_to(port: int, **command: object) -> dict[str, object]:
    with live(port, DRIVE) as socket:
        socket.send(json.dumps({"id": 7, **command}))
        while True:
            message = json.loads(socket.recv(timeout=30))
            if message.get("id") == 7:
                return message


@pytest.mark.parametrize("name", ["laser_model_type", "robot_model_type"])
def test_a_token_that_drives_does_not_run_code(port: int, proxied: int, name: str) -> None:
    values = {name: "my_filter.py:MySensor"}
    refused = answer_to(port, type="set_parameters", values=values)
    assert "--allow-code" in str(refused["message"])
    other = answer_to(port, type="set_parameters", values={"sigma_hit": 0.02})
    assert other["type"] == "ack"
    # Where it is allowed, only the model is missing.
    missing = answer_to(proxied, type="set_parameters", values=values)
    assert "there is no model" in str(missing["message"])


def test_watchers_take_no_place_that_the_driver_needs(port: int) -> None:
    opened = 0
    with ExitStack() as sockets:
        for _ in range(540):
            try:
                # They read nothing: whoever waits for the answer to a goodbye waits long.
                sockets.enter_context(live(port, WATCH, close_timeout=0.01))
            except (InvalidStatus, OSError):
                continue
            opened += 1
        assert opened > 300
        for path in ("/", "/static/main.js", "/api/state", "/camera.jpg"):
            assert status(port, path, Authorization=f"Bearer {DRIVE}") in (200, 404), path
        with live(port, DRIVE) as socket:
            assert json.loads(socket.recv(timeout=30))["type"] == "telemetry"
    assert status(port, "/", Authorization=f"Bearer {WATCH}") == 200


class Quiet(SimpleHTTPRequestHandler):
    """Serves a folder and says nothing."""

    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.mark.browser
def test_a_page_of_another_site_locks_nobody_out_by_frames(tmp_path: Path, browser) -> None:
    with at() as fresh:
        frames = "".join(
            f'<iframe src="http://{host}:{fresh}/?token=wrong{host}{number}"></iframe>'
            for number in range(3 * FREE_GUESSES)
            for host in ("127.0.0.1", "localhost")
        )
        tags = "".join(f'<embed src="http://127.0.0.1:{fresh}/?token=e{n}">' for n in range(9))
        (tmp_path / "index.html").write_text(frames + tags)
        handler = partial(Quiet, directory=tmp_path)
        with ThreadingHTTPServer(("127.0.0.1", 0), handler) as site:
            thread = threading.Thread(target=site.serve_forever)
            thread.start()
            page = browser.new_page()
            try:
                for host in ("127.0.0.1", "localhost"):  # the same site, and another one
                    page.goto(f"http://{host}:{site.server_port}/", wait_until="load")
                opened = page.goto(f"http://127.0.0.1:{fresh}/?token={DRIVE}")
                assert opened is not None
                assert opened.status == 200
            finally:
                page.close()
                site.shutdown()
                thread.join()
        # None was counted: this one is the first wrong one.
        assert [guess(fresh, number) for number in range(FREE_GUESSES)] == [401] * FREE_GUESSES
