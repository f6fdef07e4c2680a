"""What the live socket makes of a page that leaves, and of one that may not run code."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from apps import listening
from engine_runs import kinematic, run
from fastapi import FastAPI
from serving import ask
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from app.engine.program import Program
from app.messages.driving_commands import StopCommand
from app.page.live import Live
from app.page.outlets import Outlets
from app.page.token_guard import SUBPROTOCOL, TokenRequired
from app.page.tokens import Tokens
from robot.driving.drive_controller import DriveSettings

PATIENT = DriveSettings(cmd_vel_timeout=5.0)
"""A command holds until its page has left, however busy the computer is."""
DRIVE, WATCH = "drive-me", "watch-me"


@contextmanager
def page_of(program: Program, tokens: Tokens | None = None) -> Iterator[ClientConnection]:
    """A page that is open until the block ends; then its server has ended, too."""
    run(program, 0.1)
    outlets = Outlets(program)
    app = FastAPI()
    app.add_api_websocket_route("/live", Live(program, outlets).serve)
    if tokens is not None:
        app.add_middleware(TokenRequired, tokens=tokens)
    token = [Subprotocol(SUBPROTOCOL + DRIVE)] if tokens else None
    with (
        listening(app) as address,
        connect(f"ws://{address}/live", subprotocols=token) as socket,
    ):
        yield socket
    outlets.close()


@pytest.mark.parametrize(("command", "stops"), [("drive", 1), ("ping", 0)])
def test_a_page_that_closes_stops_the_robot_if_it_drove_it(command: str, stops: int) -> None:
    program = kinematic(drive=PATIENT)
    moving = {"v": 0.1, "omega": 0.0} if command == "drive" else {}
    with page_of(program) as socket:
        assert ask(socket, type=command, **moving)["type"] == "ack"
        given = program.engine.commands.take()
        assert [type(each).__name__ for each in given] == ["DriveCommand"] * stops
    stopped = [isinstance(each, StopCommand) for each in program.engine.commands.take()]
    assert stopped == [True] * stops


@pytest.mark.parametrize(("age", "answer"), [(0.0, "ack"), (0.4, "ack"), (0.7, "error")])
def test_a_drive_command_that_says_that_it_is_old_is_refused(age: float, answer: str) -> None:
    with page_of(kinematic(drive=PATIENT)) as socket:
        now = ask(socket, type="ping")["stamp"]
        told = ask(socket, type="drive", v=0.1, omega=0.0, sent=now - age)
        assert told["type"] == answer
        assert ask(socket, type="scatter", sent=now - 5)["type"] == "ack", "it is not too late"


@pytest.mark.parametrize(
    ("allowed", "told"), [(False, "started with --allow-code"), (True, "there is no model")]
)
def test_a_page_names_no_code_unless_the_program_allows_it(allowed: bool, told: str) -> None:
    values = {"laser_model_type": "my_filter.py:MySensor"}
    with page_of(kinematic(), Tokens(DRIVE, WATCH, allow_code=allowed)) as socket:
        answer = ask(socket, type="set_parameters", values=values)
    assert answer["type"] == "error" and told in answer["message"]
