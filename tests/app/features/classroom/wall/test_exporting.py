"""The archive of a class's recordings: a folder for each student, and no more than fits."""

from __future__ import annotations

import json
import threading
import zipfile
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from app.features.classroom.wall import exporting
from app.features.classroom.wall.exporting import LEFT_OUT, pack
from app.features.classroom.wall.followed import FollowedServer


@pytest.fixture
def server_of():
    """Makes a student's server of what it has at each path."""
    running = []

    def make(pages: dict[str, bytes]) -> FollowedServer:
        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                content = pages.get(self.path)
                self.send_response(404 if content is None else 200)
                self.send_header("Content-Length", str(len(content or b"")))
                self.end_headers()
                self.wfile.write(content or b"")

            def log_message(self, *_: object) -> None:
                pass

        server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        running.append(server)
        return FollowedServer(f"http://127.0.0.1:{server.server_port}/", "token")

    yield make
    for server in running:
        server.shutdown()
        server.server_close()


def listing(*names: str) -> bytes:
    return json.dumps([{"name": name} for name in names]).encode()


def packed(folder, servers) -> dict[str, bytes]:
    archive = folder / "recordings.zip"
    pack(servers, archive)
    with zipfile.ZipFile(archive) as made:
        return {name: made.read(name) for name in made.namelist()}


def test_each_student_has_a_folder_of_recordings(server_of, tmp_path):
    ada = server_of({"/api/recordings": listing("a", "b"), "/api/recordings/a": b"first",
                     "/api/recordings/b": b"second"})  # fmt: skip
    bo = server_of({"/api/recordings": listing()})
    assert packed(tmp_path, {"ada": ada, "bo": bo}) == {
        "ada/a.mcap": b"first", "ada/b.mcap": b"second",
    }  # fmt: skip


def test_a_name_that_leads_out_stays_in_the_students_folder(server_of, tmp_path):
    name = "../../evil/x y"
    ada = server_of({"/api/recordings": listing(name),
                     "/api/recordings/..%2F..%2Fevil%2Fx%20y": b"content"})  # fmt: skip
    assert packed(tmp_path, {"ada": ada}) == {"ada/_.._evil_x_y.mcap": b"content"}


def test_what_cannot_be_had_or_is_too_much_is_named(server_of, tmp_path, monkeypatch):
    monkeypatch.setattr(exporting, "MOST_OF_EACH", 10)
    ada = server_of({"/api/recordings": listing("a", "b", "gone", "c"),
                     "/api/recordings/a": b"12345678", "/api/recordings/b": b"12345678",
                     "/api/recordings/c": b"90"})  # fmt: skip
    odd = server_of({"/api/recordings": b'{"name": 3}'})
    away = FollowedServer("http://127.0.0.1:1/", "token")
    made = packed(tmp_path, {"ada": ada, "odd": odd, "away": away})
    told = made.pop(LEFT_OUT).decode().splitlines()
    assert made == {"ada/a.mcap": b"12345678", "ada/c.mcap": b"90"}
    assert [line.partition(":")[0] for line in told] == [
        "ada/b.mcap", "ada/gone.mcap", "odd", "away",
    ]  # fmt: skip
