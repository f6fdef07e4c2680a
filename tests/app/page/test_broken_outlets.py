"""What a feature runs beside the engine fails in each way: it is named, and nothing else ends."""

from __future__ import annotations

import dataclasses
import logging
import math
import threading
from typing import Literal

import httpx
import numpy as np
import pytest
from apps import listening
from engine_runs import EIGHT, kinematic, run
from fastapi import APIRouter, FastAPI
from serving import ask
from websockets.sync.client import connect

from app.engine.build import build_on_field
from app.engine.command_row import CommandRow, Part
from app.engine.driver import Driver
from app.engine.driving import Programme
from app.engine.plugging import plug_in, plugged
from app.engine.value import Value
from app.engine.values import value_failures
from app.feature import Feature
from app.features.ros.topics import TOPICS, topic_failures, topics
from app.messages.message import CommandMessage
from app.page.live import Live
from app.page.outlets import Outlet, Outlets
from app.page.serving import Server
from app.page.state import state_router
from app.page.telemetry import TelemetryWriter
from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field_loading import load_field
from robot.geometry import Twist2


class Broken(Outlet):
    """Fails in one of its parts."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.closed = 0
        self.held: dict[str, object] = {}

    @property
    def parts(self):
        return self.held

    def telemetry(self, snapshot):
        if self.where == "refuses":
            raise CommandError("no")
        return {"a place of the core": {"stamp": 0.0}, "an unknown place": {"lamp": 1}}.get(
            self.where, {}
        )

    def start(self):
        if self.where in ("start", "start and close"):
            raise KeyError("lamp")
        if self.where == "refuses to start":
            raise CommandError("there is no lamp")

    def close(self):
        self.closed += 1
        if "close" in self.where:
            raise OSError("the lamp is stuck")


class BrokenCompanion:
    """Fails at the tenth reading."""

    def __init__(self) -> None:
        self.seen = 0
        self.closed = 0

    @property
    def shown(self):
        """What values may read."""
        return self.seen

    def commands(self, odom_from_robot, controls):
        return ()

    def add(self, reading, controls):
        self.seen += 1
        if self.seen == 10:
            raise KeyError("lamp")

    def close(self):
        self.closed += 1


@pytest.fixture(autouse=True)
def put_back(caplog):
    caplog.set_level(logging.CRITICAL)
    before = plugged().features
    yield
    plug_in(before)


def with_lamps(**hooks):
    plug_in(plugged().features.adding(Feature(name="lamps", about="", **hooks)))


@pytest.mark.parametrize(
    "where", ["refuses", "a place of the core", "an unknown place", "start", "start and close"]
)
def test_an_outlet_that_fails_is_named_and_telemetry_goes_on(where):
    broken = Broken(where)
    with_lamps(outlet=lambda outlets: broken)
    program = kinematic()
    outlets = Outlets(program)
    try:
        outlets.start()
        (snapshot,) = run(program, 0.02)
        writer = TelemetryWriter(program, outlets)
        writer.message(snapshot)
        message = writer.message(snapshot)
    finally:
        outlets.close()
    (words,) = (problem for problem in message.problems if "has failed" in problem)
    assert words.startswith("The feature lamps has failed: ")
    assert message.stamp == snapshot.stamp
    assert broken.closed == 1


def test_an_outlet_that_cannot_do_what_is_asked_ends_the_start_with_its_words():
    broken = Broken("refuses to start")
    with_lamps(outlet=lambda outlets: broken)
    with pytest.raises(CommandError, match="there is no lamp"):
        Outlets(kinematic()).start()
    assert broken.closed == 1


def test_an_outlet_whose_end_fails_keeps_no_other_from_ending():
    broken, last, shared = Broken("close"), Broken(""), Broken("close")

    def outlet(outlets):
        outlets.shared(Part("lamps"), lambda: shared)
        return broken

    with_lamps(outlet=outlet)
    plug_in(plugged().features.adding(Feature(name="z", about="", outlet=lambda outlets: last)))
    outlets = Outlets(kinematic())
    outlets.start()
    outlets.close()
    assert [each.closed for each in (broken, last, shared)] == [1, 1, 1]


class Commanding(BrokenCompanion):
    """Gives these in each tick, and cannot end."""

    def __init__(self, given):
        super().__init__()
        self.given, self.asked = given, 0

    def add(self, reading, controls): ...

    def commands(self, odom_from_robot, controls):
        self.asked += 1
        return self.given

    def close(self):
        super().close()
        raise OSError("the lamp is stuck")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("turn left",), "TypeError: it commands 'turn left'; valid is a Command"),
        ({"type": "blink"}, "TypeError: it commands 'type'; valid is a Command"),
        (None, "TypeError: 'NoneType' object is not iterable"),
        ("blink", "The feature lamps cannot be used: KeyError: 'lamp' (test_broken_outlets.py:"),
        ("wave", "nothing here carries out wave: a feature was left out"),
    ],
)
def test_a_companion_whose_command_fails_is_named_and_left_out_and_the_robot_drives(given, words):
    commands = {"blink": (BlinkCommand(type="blink"),), "wave": (WaveCommand(type="wave"),)}
    companion = Commanding(commands[given] if isinstance(given, str) else given)
    with_lamps(
        companions=(lambda config, robot, field: (companion,),),
        commands=(lambda: [CommandRow(BlinkCommand, lambda tick: {}["lamp"])],),
    )
    program = kinematic()
    shown = run(program, 1.0, EIGHT)
    (problem,) = shown[-1].problems.present
    assert problem.startswith(f"The feature lamps no longer follows the drive: {words}")
    assert (companion.asked, companion.closed) == (1, 1)
    assert shown[-1].problems.count == 1
    assert shown[-1].twist.v > 0


@pytest.mark.parametrize("who", ["companion", "robot"])
def test_what_cannot_be_closed_is_logged_and_the_others_end(who, caplog):
    caplog.set_level(logging.ERROR)
    first, second = Commanding(()), Commanding(())
    with_lamps(companions=(lambda config, robot, field: (first, second),))
    program = kinematic()
    if who == "robot":
        program.robot.close = lambda: {}["wheel"]
    stop = threading.Event()
    stop.set()
    program.engine.run(stop)
    assert (first.closed, second.closed) == (1, 1)
    named = program.robot.name if who == "robot" else "lamps"
    assert f"{named} failed at its end" in caplog.text


def test_another_field_is_used_though_the_robot_cannot_be_closed():
    program = kinematic()
    program.robot.close = lambda: {}["wheel"]
    following = build_on_field(program, "town", load_field("town", MAPS))
    assert following.field.name == "town"
    following.robot.close()


def test_a_route_that_fails_is_named():
    def routers(program):
        router = APIRouter()

        @router.get("/api/lamps/{which}")
        def lamp(which: str):
            return {}[which]

        return router

    with_lamps(routers=(routers,))
    server = Server(kinematic())
    words = "The address /api/lamps/{which} failed: KeyError: 'red' (test_broken_outlets.py:"
    with listening(server._uvicorn.config.app) as address:
        answer = httpx.get(f"http://{address}/api/lamps/red")
        httpx.get(f"http://{address}/api/lamps/blue")
        health = httpx.get(f"http://{address}/api/health").json()
    assert answer.status_code == 500
    assert answer.json()["detail"].startswith(words)
    (failure,) = server._outlets.failures
    assert failure.startswith(words.replace("red", "blue"))
    assert failure in health["detail"]
    server._outlets.close()


def test_problems_of_features_are_counted_and_listed_with_the_others():
    with_lamps(outlet=lambda outlets: {}["lamp"])
    program = kinematic()
    run(program, 0.02)
    outlets = Outlets(program)
    (snapshot,) = run(program, 0.02)
    message = TelemetryWriter(program, outlets).message(snapshot)
    assert message.error_count == len(message.problems) == 1
    app = FastAPI()
    app.include_router(state_router(program, None, (), outlets))
    with listening(app) as address:
        listed = httpx.get(f"http://{address}/api/problems").json()["problems"]
    assert [problem["message"] for problem in listed] == message.problems
    outlets.close()


def test_a_companion_that_fails_is_told_and_closed_and_the_robot_drives():
    companion = BrokenCompanion()
    with_lamps(companions=(lambda config, robot, field: (companion,),))
    shown = run(kinematic(), 1.0, EIGHT)
    assert companion.seen == 10
    assert companion.closed == 1
    words = (
        "The feature lamps no longer follows the drive: KeyError: 'lamp' (test_broken_outlets.py:"
    )
    assert any(problem.startswith(words) for problem in shown[-1].problems.present)
    assert shown[-1].twist.v > 0


def test_companions_that_cannot_be_made_are_told_and_the_robot_drives():
    with_lamps(companions=(lambda config, robot, field: [1 / 0],))
    shown = run(kinematic(), 1.0, EIGHT)
    (words,) = (problem for problem in shown[-1].problems.present if "lamps" in problem)
    assert "ZeroDivisionError: division by zero (test_broken_outlets.py:" in words
    assert "; --without lamps" in words
    assert shown[-1].problems.count == 1
    assert shown[-1].twist.v > 0


def test_what_a_companion_shows_is_in_each_tick_for_values():
    value = Value("pictures", lambda snapshot: snapshot.added["lamps"])
    with_lamps(companions=(lambda *_: (BrokenCompanion(),),), values=(lambda: [value],))
    shown = run(kinematic(), 0.1)
    assert [value.shown(snapshot) for snapshot in shown] == [1, 2, 3, 4, 5]


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (lambda snapshot: 1 / 0, "ZeroDivisionError: division by zero (test_broken_outlets.py:"),
        (
            lambda snapshot: [3],
            "TypeError: it is list; valid is a number, ",
        ),
    ],
)
def test_a_value_that_cannot_be_read_is_named_and_the_others_are_shown(read, words):
    with_lamps(values=(lambda: [Value("bad", read), Value("good", lambda _: np.float32(2.5))],))
    program = kinematic()
    (snapshot,) = run(program, 0.02)
    outlets = Outlets(program)
    message = TelemetryWriter(program, outlets).message(snapshot)
    outlets.close()
    assert message.values | {"bad": None, "good": 2.5} == message.values
    (told,) = message.problems
    assert told.startswith(f"The value bad cannot be read: {words}")


@pytest.mark.parametrize("number", [math.nan, -math.inf, np.float64("nan")])
def test_a_value_that_is_no_number_is_unknown_and_no_problem(number):
    value = Value("share", lambda _: number, ".1f")
    (snapshot,) = run(kinematic(), 0.02)
    assert value.shown(snapshot) is None
    assert value.text(snapshot) == ""
    assert value_failures() == []


class BlinkCommand(CommandMessage):
    """A command of a feature."""

    type: Literal["blink"]


class WaveCommand(CommandMessage):
    """A command that nothing carries out."""

    type: Literal["wave"]


def test_a_command_that_fails_is_a_problem_until_it_succeeds():
    broken = [True]
    row = CommandRow(BlinkCommand, lambda tick: broken and {}["lamp"])
    with_lamps(commands=(lambda: [row],))
    program = kinematic()
    (failed,) = run(program, 0.02, BlinkCommand(type="blink"))
    assert len(failed.problems.present) == 1
    broken.clear()
    (well,) = run(program, 0.02, BlinkCommand(type="blink"))
    assert well.problems.present == ()


def test_a_command_that_fails_is_named_the_robot_stops_and_goes_on():
    with_lamps(commands=(lambda: [CommandRow(BlinkCommand, lambda tick: {}["lamp"])],))
    program = kinematic()
    run(program, 0.5, EIGHT)
    program.engine.commands.put(BlinkCommand(type="blink"))
    (stopped,) = run(program, 0.02)
    assert stopped.mode == "idle"
    (words,) = stopped.problems.present
    assert words.startswith(
        "The command blink failed: The feature lamps cannot be used: KeyError: "
    )
    assert "'lamp' (test_broken_outlets.py:" in words
    assert stopped.problems.record[-1].message == words
    assert program.engine.failure is None
    assert run(program, 0.5, EIGHT)[-1].twist.v > 0


def test_a_programme_of_a_feature_has_a_mode_of_its_own():
    programme = Programme("dance", lambda t: Twist2(0.0, 1.0))
    row = CommandRow(BlinkCommand, lambda tick: tick.controls.driving.perform(
        programme, tick.controls.stamp, start=True
    ))  # fmt: skip
    with_lamps(commands=(lambda: [row],))
    program = kinematic()
    program.engine.commands.put(BlinkCommand(type="blink"))
    shown = run(program, 0.1)
    outlets = Outlets(program)
    assert TelemetryWriter(program, outlets).message(shown[-1]).mode == "dance"
    outlets.close()
    assert shown[-1].twist.omega > 0


def test_an_outlet_that_could_not_start_gets_no_commands():
    part = Part("lamps' part")
    row = CommandRow(BlinkCommand, act=lambda request: request.part(part))
    broken = Broken("start")
    broken.held = {part.name: broken}
    with_lamps(outlet=lambda outlets: broken, commands=(lambda: [row],))
    outlets = Outlets(kinematic())
    outlets.start()
    with pytest.raises(CommandError, match="runs without the lamps' part"):
        outlets.carry_out(Driver("somebody"), BlinkCommand(type="blink"))
    outlets.close()


@pytest.mark.parametrize("where", ["act", "check"])
def test_a_command_whose_own_code_fails_is_answered_and_the_socket_stays(where):
    def fail(*_):
        raise KeyError("lamp")

    with_lamps(commands=(lambda: [CommandRow(BlinkCommand, **{where: fail})],))
    program = kinematic()
    run(program, 0.1)
    outlets = Outlets(program)
    app = FastAPI()
    app.add_api_websocket_route("/live", Live(program, outlets).serve)
    with listening(app) as address, connect(f"ws://{address}/live") as socket:
        answers = [ask(socket, type=name, id=name) for name in ("blink", "ping")]
    outlets.close()
    assert (answers[0]["type"], answers[0]["id"]) == ("error", "blink")
    words = "The feature lamps cannot be used: KeyError: 'lamp' (test_broken_outlets.py:"
    assert answers[0]["message"].startswith(words)
    assert (answers[1]["type"], answers[1]["id"]) == ("ack", "ping")


@pytest.mark.parametrize("name", ["scan", "lamp"])
def test_a_feature_whose_topics_cannot_be_used_is_named_and_the_others_publish(name):
    """One has the name of ours, the other is no topic."""
    made = dataclasses.replace(TOPICS[0], name=name) if name == "scan" else object()
    others = topics()
    with_lamps(topics=(lambda: (made,),))
    assert topics() == others
    (failure,) = topic_failures()
    assert failure.startswith("The feature lamps cannot be used")
    assert ".py" not in failure  # it is our code that refuses
    outlets = Outlets(kinematic())
    assert failure in outlets.failures
    outlets.close()
