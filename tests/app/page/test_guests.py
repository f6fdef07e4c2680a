"""Pages of other sites: Foxglove's comes in by its link alone, and nothing else listens."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from urllib.parse import urlsplit

import psutil
import pytest
from serving import started
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

FOXGLOVE = "https://app.foxglove.dev"
PROTOCOL = "foxglove.sdk.v1"
REFUSED = 403


@pytest.fixture(scope="module")
def program() -> Iterator[tuple[psutil.Process, str]]:
    """A program without tokens, and the link that it prints for Foxglove."""
    options = ("--robot", "kinematic", "--map", "stub", "--port", "0", "--foxglove")
    with started("run", *options, says=r"Foxglove opens (\S+)") as (process, link):
        while "BrickPose is at" not in process.stdout.readline():
            pass
        yield psutil.Process(process.pid), link


@pytest.fixture
def link(program) -> str:
    return program[1]


def opened(address: str, **headers: str):
    origin = headers.pop("origin", None)
    return connect(
        address, origin=origin, additional_headers=headers, subprotocols=[PROTOCOL], open_timeout=90
    )


def status_of(address: str, **headers: str) -> int:
    """How a websocket is refused."""
    with pytest.raises(InvalidStatus) as refused, opened(address, **headers):
        pass
    return refused.value.response.status_code


def bare(link: str) -> str:
    return link.partition("?")[0]


@pytest.mark.slow
def test_foxgloves_page_comes_in_by_its_link(link) -> None:
    for origin in (FOXGLOVE, "file://", "null", None):
        with opened(link, **({"origin": origin} if origin else {})) as viewer:
            assert json.loads(viewer.recv(timeout=30))["op"] == "serverInfo"


def test_who_is_no_page_needs_no_link(link) -> None:
    with opened(bare(link)) as viewer:
        assert json.loads(viewer.recv(timeout=30))["op"] == "serverInfo"


@pytest.mark.parametrize("origin", [FOXGLOVE, "http://evil.example", "null", "file://"])
def test_a_foreign_page_without_the_link_is_refused(link, origin) -> None:
    assert status_of(bare(link), origin=origin) == REFUSED
    assert status_of(f"{bare(link)}?token=wrong-one", origin=origin) == 401


def test_a_cookie_of_ours_lets_no_foreign_page_in(link) -> None:
    port, token = urlsplit(link).port, link.rpartition("=")[2]
    cookie = f"brickpose-{port}={token}"
    assert status_of(f"{bare(link)}?token=wrong-one", origin=FOXGLOVE, cookie=cookie) == 401


@pytest.mark.parametrize("path", ["/", "/rosbridge", "/api/live", "/api/camera", "/view"])
def test_the_link_opens_no_other_door(link, path) -> None:
    address = link.replace("/foxglove", path)
    assert status_of(address, origin="http://evil.example") == REFUSED


def test_a_name_that_is_not_ours_is_refused_with_the_link_too(link) -> None:
    parts = urlsplit(link)
    for address in (link, bare(link)):
        foreign = address.replace(parts.hostname, "evil.example")
        raw = socket.create_connection((parts.hostname, parts.port))
        with raw, pytest.raises(InvalidStatus) as refused:
            connect(foreign, sock=raw, origin=FOXGLOVE, subprotocols=[PROTOCOL])
        assert refused.value.response.status_code == REFUSED


def test_nothing_listens_besides_the_one_port(program) -> None:
    process, link = program
    with opened(link.replace("/foxglove", "/api/live")):
        family = [process, *process.children(recursive=True)]
        open_ = [one for each in family for one in each.net_connections("inet")]
        ports = {one.laddr.port for one in open_ if one.status in ("LISTEN", "NONE")}
    assert ports == {urlsplit(link).port}
