"""From a robot to a recording, to another field and back: a stop holds; one change at a time."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from serving import ServedProgram, answer, ask, serving, telemetry, until
from websockets.exceptions import ConnectionClosed, WebSocketException

from app.engine.build import build_program
from app.engine.commands import check
from app.engine.drivers import Driver
from app.engine.program import Program
from app.features.recordings.commands import OPENER
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.library import listed
from app.features.recordings.messages import CloseRecordingCommand
from app.features.recordings.replay import succession
from app.features.recordings.replay.opening import ReplayProgram
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.features.recordings.replay.succession import replay_after
from app.messages.driving_commands import StopCommand
from app.page.outlets import Outlets
from app.settings.config import Config
from app.settings.groups import RecordingSettings
from robot.errors import CommandError
from robot.interface import RobotError

pytestmark = pytest.mark.slow

BACK_S = 30.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("recordings")


@pytest.fixture(scope="module")
def server(folder) -> Iterator[ServedProgram]:
    config = folder / "settings.toml"
    config.write_text(f"[recording]\nfolder = {json.dumps(str(folder))}\n", encoding="utf-8")
    with serving("--robot", "kinematic", "--map", "stub", "--config", str(config)) as running:
        with running.live() as live:
            ask(live, type="record", on=True)
            until(live, lambda now: now["recording"] and now["recording"]["duration_s"] > 1)
            ask(live, type="record", on=False)
            until(live, lambda now: not now["recording"]["running"])
        yield running


def after(server: ServedProgram, condition) -> dict:
    """Telemetry of the program that follows, as soon as a condition holds."""
    end = time.monotonic() + BACK_S
    while time.monotonic() < end:
        with suppress(OSError, WebSocketException), server.live() as live:
            now = telemetry(live)
            if condition(now):
                return now
    raise TimeoutError


def test_a_stop_holds_while_a_recording_is_open_and_behind_it(server, folder) -> None:
    with server.live() as live:
        assert ask(live, type="stop")["type"] == "ack"
        [recorded] = listed(folder)
        # Both are on their way before the program ends.
        live.send(json.dumps({"type": "open_recording", "name": recorded.name}))
        live.send(json.dumps({"type": "use_field", "name": "square"}))
        assert answer(live)["type"] == "ack"
        # On a busy machine the program has ended before it answers the second.
        with suppress(ConnectionClosed):
            assert "is already switching" in answer(live)["message"]
    # The first one won.
    assert after(server, lambda now: now["replay"] is not None)["driver"]["stopped"]
    with server.live() as live:
        assert ask(live, type="close_recording")["type"] == "ack"
    assert after(server, lambda now: now["replay"] is None)["driver"]["stopped"]


def test_a_full_disk_is_told_on_the_next_field_too_until_it_has_room(small_disk, tmp_path) -> None:
    config = tmp_path / "settings.toml"
    config.write_text(f"[recording]\nfolder = {json.dumps(str(small_disk))}\n", encoding="utf-8")
    other = small_disk / "other"
    other.write_bytes(bytes(2_900_000))
    with serving("--robot", "kinematic", "--map", "stub", "--config", str(config)) as server:
        with server.live() as live:
            ask(live, type="record", on=True)
            until(live, _full)
            assert ask(live, type="use_field", name="square")["type"] == "ack"
        assert _full(after(server, lambda now: now["map"] == "square"))
        other.unlink()
        after(server, lambda now: not _full(now))


def _full(now: dict) -> bool:
    return any(words.startswith("The disk is full") for words in now["problems"])


def test_a_map_that_is_drawn_is_not_lost_by_a_change(server, folder) -> None:
    with server.live() as live:
        assert ask(live, type="start_map")["type"] == "ack"
        for command in (
            {"type": "open_recording", "name": listed(folder)[0].name},
            {"type": "use_field", "name": "square"},
        ):
            assert "a map is drawn" in ask(live, **command)["message"]
        assert ask(live, type="discard_map")["type"] == "ack"


def test_from_a_recording_that_was_deleted_meanwhile_there_is_a_way_back(folder, server) -> None:
    before = build_program(Config(robot="kinematic", map="stub"))
    replay = replay_after(before, listed(folder)[0].file.parent)
    replay.engine.fail("The replay stopped: its file is gone")
    with pytest.raises(CommandError, match="its file is gone"):
        check(StopCommand(type="stop"), replay)
    check(CloseRecordingCommand(type="close_recording"), replay)
    before.robot.close()


def test_a_recording_that_fails_at_once_is_not_opened(folder, monkeypatch) -> None:
    """Else its page would have no telemetry, so no way back."""

    def broken(*_: object) -> None:
        raise ValueError("no such tick")

    recording = RecordingSettings(folder=str(folder))
    before = build_program(Config(robot="kinematic", map="stub", recording=recording))
    made: list[Callable[[], Program]] = []
    outlets = Outlets(before, go_on=made.append)
    [recorded] = listed(folder)
    driver = Driver("a page")
    monkeypatch.setattr(RecordedRobot, "read", broken)
    with pytest.raises(RecordingError, match=f"{recorded.name} cannot be replayed: no such tick"):
        outlets.part(OPENER).open(driver, recorded.name)
    assert made == []
    monkeypatch.undo()
    outlets.part(OPENER).open(driver, recorded.name)
    following = made[0]()
    assert isinstance(following, ReplayProgram)
    stop = threading.Event()
    stop.set()
    following.replay.run(stop)
    newest = following.engine.latest.get()
    assert newest is not None and newest.replay is not None and newest.replay.position_s == 0
    before.robot.close()


def test_who_cannot_go_back_to_the_robot_stays_in_the_recording(
    server, folder, monkeypatch
) -> None:
    def unplugged(*_: object) -> None:
        raise RobotError("the Build HAT does not answer")

    before = build_program(Config(robot="kinematic", map="stub"))
    replay = replay_after(before, listed(folder)[0].file.parent)
    made: list[Callable[[], Program]] = []
    monkeypatch.setattr(succession, "build_served", unplugged)
    Outlets(replay, go_on=made.append).part(OPENER).close()
    following = made[0]()
    assert isinstance(following, ReplayProgram)
    assert following.before == before.config
    [noted] = [item.message for item in following.engine.controls.problems.record]
    assert noted == "There is no way back to the robot yet: the Build HAT does not answer"
    before.robot.close()
