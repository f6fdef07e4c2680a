"""Each command on a computer without Unix: it works, or says in a line what is not to be had.

``without_unix.py`` tells what is simulated.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import laser_office
import pytest
import without_unix
from course.solutions import ARRAYS
from engine_runs import EIGHT
from recordings import record
from websockets.sync.client import connect

from app.engine.build import build_program
from app.settings.config import Config, with_settings

pytestmark = pytest.mark.slow

PATIENCE_S = 120.0
SLOW_HZ = 8.0
"""Pictures a second where a few are enough."""
SWEEP = """
[sweep]
seeds = 1
worlds = ["kinematic"]

[settings]
localization.filter.min_particles = [100]
"""


@dataclass(frozen=True)
class Ended:
    """A command that has ended."""

    code: int
    out: str
    err: str


class Computer:
    """Runs commands in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._serving: dict[str, int] = {}
        self._process = subprocess.Popen(
            [sys.executable, without_unix.__file__],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder,
            env=os.environ | {"LOCALAPPDATA": str(folder / "Local"), "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip

    def run(self, *arguments: object) -> Ended:
        for left in self.folder.glob("command.*"):
            left.unlink()
        self._order("command", arguments, serves=False)
        assert (self.folder / "command.code").exists(), self.told("command", "err")
        return self.ended("command")

    def serve(self, name: str, *arguments: object) -> int:
        """Start a server; return its process's number."""
        self._serving[name] = self._order(name, arguments, serves=True)
        return self._serving[name]

    def ended(self, name: str) -> Ended:
        """Wait for the end of a command, and return it."""
        code = self.folder / f"{name}.code"
        wait_until(code.exists)
        result = Ended(int(code.read_text()), self.told(name, "out"), self.told(name, "err"))
        code.unlink()
        self._serving.pop(name, None)
        return result

    def told(self, name: str, stream: str) -> str:
        file = self.folder / f"{name}.{stream}"
        return file.read_text(encoding="cp1252") if file.exists() else ""

    def close(self) -> None:
        for left in self._serving.values():  # a test has failed
            os.kill(left, signal.SIGKILL)
        with self._process:  # closes its pipes; then it ends
            assert self._process.stdin is not None
        assert self._process.returncode == 0

    def _order(self, name: str, arguments: tuple[object, ...], *, serves: bool) -> int:
        order = {"arguments": [str(item) for item in arguments], "folder": str(self.folder)}
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.write(json.dumps(order | {"name": name, "serves": serves}) + "\n")
        self._process.stdin.flush()
        return int(self._process.stdout.readline())


def wait_until(condition) -> None:
    end = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


@pytest.fixture(scope="module")
def computer(tmp_path_factory) -> Iterator[Computer]:
    made = Computer(tmp_path_factory.mktemp("Müllers Rechner"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def recording(computer) -> Path:
    """A lap of the figure-eight on the square."""
    config = with_settings(Config(robot="kinematic", seed=61), {"sim.camera.frame_rate": SLOW_HZ})
    program = build_program(config)
    try:
        made, _, _ = record(program, computer.folder, 16.5, EIGHT)
    finally:
        program.robot.close()
    return made


def succeeded(done: Ended) -> str:
    assert (done.code, done.err) == (0, "")
    return done.out


def refused(done: Ended, words: str) -> None:
    assert done.code == 1
    assert words in done.err
    assert done.err.count("\n") == 1, "a line, and no traceback"


def test_run_serves_and_record_records_until_ctrl_break_stops_the_robot(computer):
    port = free_port()
    running = computer.serve("run", "run", "--robot", "kinematic", "--port", port)
    wait_until(lambda: f"127.0.0.1:{port}" in computer.told("run", "out"))
    with connect(f"ws://127.0.0.1:{port}/api/live", max_size=None) as live:
        live.send(json.dumps({"type": "drive", "v": 0.1, "omega": 0.0}))
        out = succeeded(computer.run("record", f"127.0.0.1:{port}", "--seconds", "1"))
        assert "brickpose_" in out
        os.kill(running, without_unix.SIGBREAK)
        done = computer.ended("run")
    # A client that does not hang up within a second is left, and that is said.
    assert done.code == 0
    assert done.err in (
        "",
        "ERROR:    Cancel 0 running task(s), timeout graceful shutdown exceeded\n",
    )
    assert next(computer.folder.glob("brickpose_*/*.mcap")).stat().st_size > 10_000


def test_learn_serves_a_lesson_and_begins_the_file(computer):
    port = free_port()
    serving = computer.serve(
        "learn", "learn", "--robot", "kinematic", "--port", port, "--file", "filter.py"
    )
    wait_until(lambda: "/learn/1" in computer.told("learn", "out"))
    os.kill(serving, without_unix.SIGBREAK)
    assert computer.ended("learn").code == 0
    assert "def " in (computer.folder / "filter.py").read_text(encoding="utf-8")


def test_check_grades_a_file_that_begins_with_a_mark(computer):
    file = computer.folder / "mine.py"
    file.write_text(ARRAYS.replace("\n", "\r\n"), encoding="utf-8-sig", newline="")
    assert "passed" in succeeded(computer.run("check", file, "--lesson", 1))


def test_check_prints_what_the_terminal_has_no_sign_for(computer):
    folder = computer.folder / "class"
    folder.mkdir()
    (folder / "mine.py").write_text(ARRAYS, encoding="utf-8")
    out = succeeded(computer.run("check", folder, "--lesson", 1, "--workers", 1))
    assert "? passed" in out  # the tick


def test_replay_writes_trajectories(computer, recording):
    out = succeeded(computer.run("replay", recording, "--out", "replayed"))
    assert "estimated.tum" in out
    assert (computer.folder / "replayed" / "estimated.tum").is_file()


def test_map_draws_the_field(computer, recording):
    assert "4 strokes of tape" in succeeded(computer.run("map", recording, "--out", "floor.svg"))


def test_evaluate_uses_processes_of_this_machine(computer):
    options = ("--world", "kinematic", "--seeds", 1, "--laps", 1, "--workers", 1, "--out", "result")
    succeeded(computer.run("evaluate", *options))
    assert json.loads((computer.folder / "result" / "results.json").read_text())["recovery"]


def test_sweep_writes_a_row_a_point(computer):
    (computer.folder / "sweep.toml").write_text(SWEEP, encoding="utf-8-sig")
    succeeded(computer.run("sweep", "sweep.toml", "--workers", 1, "--out", "swept"))
    assert (computer.folder / "swept" / "results.csv").read_text().count("\n") == 2


def test_calibrate_measures_a_robot(computer):
    settings = computer.folder / "slow.toml"
    settings.write_text(f"[sim.camera]\r\nframe_rate = {SLOW_HZ}\r\n", encoding="utf-8-sig")
    options = ("--seconds", 8, "--config", settings, "--out", "profile.toml")
    succeeded(computer.run("calibrate", "drive", "--robot", "kinematic", *options))
    assert (computer.folder / "profile.toml").is_file()


def test_localize_finds_a_laser(computer):
    bag = laser_office.write_bag(computer.folder / "drive")
    chart = laser_office.write_map(computer.folder)
    succeeded(computer.run("localize", bag, "--map", chart, "--out", "located"))
    assert (computer.folder / "located" / "localized.tum").is_file()


def test_doctor_says_what_holds_a_students_file(computer):
    done = computer.run("doctor", "--robot", "kinematic")
    assert done.err == ""
    assert "held by a job of Windows, Python's own events; not by the kernel" in done.out


def test_export_writes_a_package(computer):
    assert "nav2.yaml" in succeeded(computer.run("export", "ros2", "ros"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("emulate-hat",), "needs the pseudo-terminals of Linux or macOS"),
        (("stop-motors",), "--serial-port names one, as COM3"),
        (("run", "--robot", "buildhat", "--port", "0"), "--serial-port names one, as COM3"),
        (("run", "--robot", "kinematic", "--ros2", "--port", "0"), "over DDS is for Linux"),
    ],
)
def test_what_is_not_to_be_had_is_told_in_a_line(computer, arguments, words):
    refused(computer.run(*arguments), words)
