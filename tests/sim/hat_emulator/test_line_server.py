"""Lines of commands from a socket or a keyboard, and their answers."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from emulator_bench import Bench

from sim.hat_emulator.line_server import LONGEST_LINE, Lines, LineServer, TypedLines


@pytest.fixture
def bench() -> Iterator[Bench]:
    with closing(Bench()) as made:
        yield made


def test_lines_are_put_together_from_pieces() -> None:
    lines = Lines(lambda text: f"<{text}>")
    assert lines.feed(b"one\r\ntw") == b"<one>\n"
    assert lines.feed(b"o\n\n  \nthree\n") == b"<two>\n<three>\n"
    with pytest.raises(ValueError, match="longer than"):
        lines.feed(b"x" * (LONGEST_LINE + 1))


def connect(path: Path) -> socket.socket:
    connection = socket.socket(socket.AF_UNIX)
    connection.settimeout(1)
    connection.connect(str(path))
    return connection


def gone(connection: socket.socket) -> bool:
    try:
        return connection.recv(100) == b""
    except ConnectionResetError:
        return True


def test_programs_are_answered_through_the_socket(bench: Bench, tmp_path: Path) -> None:
    path = tmp_path / "hands"
    server = LineServer(path, bench.ask, bench.emulator.loop)
    with connect(path) as one, connect(path) as other:
        one.sendall(b"supply 7")
        other.sendall(b"stall A\nduty\n")
        bench.run(0.01)
        one.sendall(b".2\n")
        bench.run(0.01)
        assert one.recv(100) == b"ok\n"
        assert other.recv(100) == b"ok\n0.0000 0.0000 0.0000 0.0000\n"
        other.sendall(b"x" * (LONGEST_LINE + 100))
        bench.run(0.01)
        assert gone(other)
    assert bench.emulator.board.supply_v == 7.2
    bench.run(0.01)
    server.close()
    server.close()
    assert not path.exists()


def test_the_socket_closes_on_those_who_still_talk(bench: Bench, tmp_path: Path) -> None:
    server = LineServer(tmp_path / "hands", bench.ask, bench.emulator.loop)
    with connect(tmp_path / "hands") as one:
        bench.run(0.01)
        server.close()
        assert one.recv(100) == b""
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"


def test_typed_lines_are_answered_until_nobody_types_any_more(bench: Bench) -> None:
    source, typing = os.pipe()
    said: list[str] = []
    TypedLines(source, bench.ask, bench.emulator.loop, said.append)
    os.write(typing, b"truth\nstall B\n")
    bench.run(0.01)
    assert len(said) == 1
    assert said[0].splitlines()[1] == "ok"
    os.close(typing)
    bench.run(0.01)
    assert bench.say("vin\r") == "\r\n8.00 V\r\n"
    os.close(source)
