"""The student's file, read and written by the page of a browser on the same computer."""

from __future__ import annotations

import anyio
import httpx
import pytest
from fastapi import FastAPI

from app.features.course.student_file import CHANGED, ELSEWHERE, NO_CODE, student_file_router
from app.page.token_guard import TokenRequired
from app.page.tokens import Tokens

ADDRESS = "/api/student_file"


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my_filter.py"
    path.write_text("a = 1\r\n", newline="")
    return path


def ask(file, method, message=None, *, client="127.0.0.1", token=None, code=False, **more):
    app = FastAPI()
    app.include_router(student_file_router(file))
    if token:
        app.add_middleware(TokenRequired, tokens=Tokens("drive-me", "watch-me", allow_code=code))

    async def request():
        transport = httpx.ASGITransport(app, client=(client, 5000))
        headers = more | ({"Authorization": f"Bearer {token}"} if token else {})
        async with httpx.AsyncClient(transport=transport, base_url="http://robot") as session:
            return await session.request(method, ADDRESS, json=message, headers=headers)

    return anyio.run(request)


@pytest.mark.parametrize("client", ["127.0.0.1", "::1", "::ffff:127.0.0.1"])
def test_it_is_read_and_written_as_a_whole(file, client):
    read = ask(file, "GET", client=client).json()
    assert read["text"] == "a = 1\r\n"
    wrote = ask(file, "PUT", read | {"text": 'b = "ü"\n'}, client=client)
    assert wrote.status_code == 200
    assert file.read_bytes() == 'b = "ü"\n'.encode()
    assert wrote.json() == ask(file, "GET", client=client).json()
    assert list(file.parent.iterdir()) == [file]


TRIES = (("GET", None), ("PUT", {"text": "evil", "version": ""}))


@pytest.mark.parametrize("client", ["192.168.1.7", "::ffff:192.168.1.7", "10.0.0.1", "testclient"])
def test_no_other_computer_reads_or_writes_it(file, client):
    before = file.read_bytes()
    for method, message in TRIES:
        answer = ask(file, method, message, client=client)
        assert (answer.status_code, answer.json()["detail"]) == (403, ELSEWHERE)
    assert file.read_bytes() == before


@pytest.mark.parametrize("header", ["X-Forwarded-For", "Forwarded", "X-Real-IP", "Via"])
def test_what_a_proxy_passes_on_is_not_from_here(file, header):
    for method, message in TRIES:
        answer = ask(file, method, message, **{header: "127.0.0.1"})
        assert (answer.status_code, answer.json()["detail"]) == (403, ELSEWHERE)


@pytest.mark.parametrize("client", ["127.0.0.1", "::1", "192.168.1.7"])
def test_where_a_token_is_asked_for_nobody_writes_it(file, client):
    """A proxy that does not say so makes every request come from this computer."""
    before = file.read_bytes()
    for token in ("drive-me", "watch-me"):
        for method, message in TRIES:
            answer = ask(file, method, message, client=client, token=token)
            assert answer.status_code == 403
    assert ask(file, "GET", client=client, token="drive-me").json()["detail"] == NO_CODE
    assert file.read_bytes() == before


@pytest.mark.parametrize("client", ["127.0.0.1", "192.168.1.7"])
def test_with_code_allowed_who_drives_writes_it_and_who_watches_does_not(file, client):
    for method, message in TRIES:
        told = ask(file, method, message, client=client, token="watch-me", code=True)
        assert told.status_code == 403
    read = ask(file, "GET", client=client, token="drive-me", code=True).json()
    wrote = ask(file, "PUT", read | {"text": "b = 2"}, client=client, token="drive-me", code=True)
    assert wrote.status_code == 200
    assert file.read_text() == "b = 2"


def test_what_another_editor_wrote_meanwhile_is_not_lost(file):
    read = ask(file, "GET").json()
    file.write_text("c = 3\n")
    answer = ask(file, "PUT", read | {"text": "b = 2\n"})
    assert (answer.status_code, answer.json()["detail"]) == (409, CHANGED)
    assert file.read_text() == "c = 3\n"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a = '\xff'", "is not in UTF-8"),
        (b"#" * 200_001, "valid are up to"),
        (None, "cannot be read"),
    ],
)
def test_what_cannot_be_shown_whole_is_refused_and_stays(file, content, words):
    if content is None:
        file.unlink()
    else:
        file.write_bytes(content)
    for method, message in (("GET", None), ("PUT", {"text": "b = 2", "version": ""})):
        answer = ask(file, method, message)
        assert answer.status_code == 409
        assert words in answer.json()["detail"]
    assert (file.read_bytes() if file.exists() else None) == content


def test_a_folder_that_cannot_be_written_is_told(file, monkeypatch):
    def full(*_args, **_more):
        raise OSError(28, "No space left on device")

    read = ask(file, "GET").json()
    monkeypatch.setattr("pathlib.Path.write_text", full)
    answer = ask(file, "PUT", read | {"text": "b = 2"})
    assert answer.status_code == 409
    assert answer.json()["detail"] == "my_filter.py cannot be written: No space left on device"
    assert file.read_bytes() == b"a = 1\r\n"
