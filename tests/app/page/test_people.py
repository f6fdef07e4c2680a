"""Whose page a connection is, and what others read of it."""

from __future__ import annotations

import pytest
from starlette.requests import HTTPConnection
from starlette.responses import Response

from app.page.people import driver_of, know

LAPTOP = "Mozilla/5.0 (X11; Linux x86_64) AppleWebKit/537.36 Chrome/140.0 Safari/537.36"
PHONE = "Mozilla/5.0 (Linux; Android 15; Pixel 9) AppleWebKit/537.36 Chrome/140.0 Mobile Safari/537"
TABLET = "Mozilla/5.0 (Linux; Android 14; SM-X200) AppleWebKit/537.36 Chrome/140.0 Safari/537.36"


def socket(query: str = "", agent: str = LAPTOP, cookie: str = "", host: str = "127.0.0.1"):
    headers = [(b"user-agent", agent.encode()), (b"cookie", cookie.encode())]
    return HTTPConnection({
        "type": "websocket", "headers": headers, "query_string": query.encode(),
        "client": (host, 5000), "server": ("127.0.0.1", 8080), "path": "/api/live", "scheme": "ws",
    })  # fmt: skip


def test_a_browser_gets_a_number_of_its_own_once() -> None:
    cookies = []
    for _ in range(2):
        answer = Response()
        know(socket(), answer)
        cookies.append(answer.headers["set-cookie"])
    assert all("HttpOnly" in each and "samesite=strict" in each.lower() for each in cookies)
    numbers = {each.split(";")[0] for each in cookies}
    assert len(numbers) == 2
    again = Response()
    know(socket(cookie=numbers.pop()), again)
    assert "set-cookie" not in again.headers


def test_pages_of_a_browser_are_one_person_and_so_are_those_of_a_tab_without_cookies() -> None:
    cookie = "brickpose-8080-person=abcdefgh"
    one, two = driver_of(socket(cookie=cookie)), driver_of(socket("page=lesson", cookie=cookie))
    assert one.person == two.person
    assert one is not two
    other = driver_of(socket(cookie="brickpose-8081-person=abcdefgh"))
    assert other.person not in (one.person, driver_of(socket()).person)
    tabs = [driver_of(socket(f"tab={name}")) for name in ("abcdefgh", "abcdefgh", "stuvwxyz")]
    assert tabs[0].person == tabs[1].person != tabs[2].person
    assert tabs[0].person != one.person, "a tab cannot say that it is somebody's browser"
    assert driver_of(socket("tab=..")).person != driver_of(socket("tab=..")).person


@pytest.mark.parametrize(
    ("query", "agent", "name", "words"),
    [
        ("tab=abcdefgh", LAPTOP, "", "a computer"),
        ("tab=abcdefgh", PHONE, "", "a phone"),
        ("tab=abcdefgh", TABLET, "", "a tablet"),
        ("tab=abcdefgh&page=lesson", PHONE, "", "the lesson"),
        ("tab=abcdefgh", PHONE, "Ada", "the phone of Ada"),
        ("tab=abcdefgh&page=lesson", PHONE, "Ada", "the lesson of Ada"),
        ("tab=abcdefgh", PHONE, "J%C3%B6rg%0A%20%20Li", "the phone of Jörg Li"),
        ("tab=abcdefgh", PHONE, "x" * 80, f"the phone of {'x' * 30}"),
    ],
)
def test_others_read_what_it_is(query: str, agent: str, name: str, words: str) -> None:
    assert driver_of(socket(query, agent, f"brickpose-name={name}")).name == words


def test_what_is_no_page_is_a_program_and_comes_from_somewhere() -> None:
    assert driver_of(socket(host="10.0.0.7")).name.startswith("program ")
    assert driver_of(socket("tab=abcdefgh", host="10.0.0.7")).name == "a computer at 10.0.0.7"
