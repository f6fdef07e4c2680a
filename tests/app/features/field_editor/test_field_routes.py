"""Addresses of fields: what they send, and what they refuse."""

from __future__ import annotations

import json
from http.client import HTTPConnection
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from apps import listening
from fastapi import FastAPI
from places import MAPS

from app.engine.plugging import plug_in, plugged
from app.feature_search import find_features
from app.features.field_editor import routes, shelf

SQUARE = (MAPS / "square.svg").read_bytes()


class Asked:
    """An answer."""

    def __init__(self, address: str, method: str, path: str, content=None, headers=None) -> None:
        connection = HTTPConnection(address, timeout=60)
        connection.request(method, path, body=content, headers=headers or {})
        answer = connection.getresponse()
        self.status_code, self.headers, self.content = answer.status, answer.headers, answer.read()
        connection.close()

    def json(self):
        return json.loads(self.content)


class Client:
    """Asks one server."""

    def __init__(self, address: str) -> None:
        self.address = address

    def get(self, path: str, **more) -> Asked:
        return Asked(self.address, "GET", path, **more)

    def put(self, path: str, **more) -> Asked:
        return Asked(self.address, "PUT", path, **more)

    def delete(self, path: str) -> Asked:
        return Asked(self.address, "DELETE", path)


@pytest.fixture
def client(tmp_path, monkeypatch):
    """The routes of a program with a folder of its own; files are read here, which is quicker."""
    for module in (routes, shelf):
        monkeypatch.setattr(module, "read_apart", lambda read, path: read(path))
    before = plugged().features
    plug_in(find_features())
    mapping = SimpleNamespace(path=lambda: tmp_path / "fields")
    app = FastAPI()
    program = SimpleNamespace(config=SimpleNamespace(mapping=mapping))
    app.include_router(routes.field_editor_router(program))
    with listening(app) as address:
        yield Client(address)
    plug_in(before)


def test_a_drawing_is_sent_as_plain_text_and_as_strips_of_tape(client) -> None:
    evil = SQUARE.replace(b"</svg>", b"<script>alert(1)</script></svg>")
    assert client.put("/api/drawings/mine", content=evil).json() == {"name": "mine", "remarks": []}
    answer = client.get("/api/drawings/mine")
    assert answer.content == evil
    assert answer.headers["content-type"].startswith("text/plain")
    [strip] = client.get("/api/drawings/mine/strokes").json()["strokes"]
    assert (len(strip["nodes"]), strip["closed"], strip["width"]) == (4, True, 50)
    entries = {entry["name"]: entry for entry in client.get("/api/field_list").json()}
    assert entries["mine"]["own"]
    assert not entries["square"]["own"]
    assert not entries["generated-17"]["drawing"]
    assert client.delete("/api/drawings/mine").status_code == 204
    assert client.get("/api/drawings/mine").status_code == 404


def test_pictures_are_of_listed_fields_alone(client) -> None:
    png = client.get("/api/drawings/generated-17/picture.png").content
    picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert max(picture.shape) == routes.PICTURE_SIDE
    assert picture.std() > 10
    assert client.get("/api/drawings/generated-18/picture.png").status_code == 404


def test_sheets_are_a_pdf_in_the_readers_language(client) -> None:
    address = "/api/drawings/square/sheets.pdf?paper=a3"
    german = client.get(address, headers={"accept-language": "de"})
    assert german.headers["content-type"] == "application/pdf"
    assert b" Bl\xe4ttern" in german.content
    assert b" sheets" in client.get(address).content
    refused = client.get("/api/drawings/square/sheets.pdf?paper=a9")
    assert refused.status_code == 404
    assert "valid are a4, a3" in refused.json()["detail"]
    assert client.get("/api/drawings/generated-17/sheets.pdf").status_code == 404


def test_what_is_too_large_is_refused_before_it_is_kept(client, monkeypatch) -> None:
    monkeypatch.setattr(routes, "LARGEST_DRAWING", 1000)

    def endless():
        for _ in range(100):
            yield b" " * 100

    for body in (b" " * 1001, endless()):
        answer = client.put("/api/drawings/mine", content=body)
        assert answer.status_code == 413
        assert "valid are up to" in answer.json()["detail"]
    assert client.put("/api/drawings/mine", content=SQUARE).status_code == 200


def test_who_asks_while_many_wait_is_told_to_come_again(client, monkeypatch) -> None:
    monkeypatch.setattr(routes, "MOST_WAITING", 0)
    plain = FastAPI()
    router = routes.APIRouter()
    routes._add_views(router, shelf.FieldShelf(MAPS / "none"))
    plain.include_router(router)
    with listening(plain) as address:
        answer = Client(address).get("/api/drawings/square/strokes")
    assert answer.status_code == 503
    assert "try again in a moment" in answer.json()["detail"]
