"""Every command ends at once and cleanly at a signal, whatever it does just then."""

import os
import random
import signal
import subprocess
import sys
import tomllib
from contextlib import suppress
from pathlib import Path

import pytest
from course.solutions import ARRAYS
from laser_office import write_bag, write_map
from replays import recorded_eight
from serving import ROOT

from benchmarks.ends import of_session

pytestmark = pytest.mark.slow

CONSOLE_SCRIPT = "import sys; from app.__main__ import main; sys.exit(main())"

BOUND_S = 6.0
"""Time in which a command must end, on a busy machine [s]."""

START_S = 30.0

SWEEP = """
[sweep]
seeds = 2
laps = 1
worlds = ["kinematic"]

[settings]
localization.filter.min_particles = [100, 200]
"""

MODULE = [sys.executable, "-X", "faulthandler", "-m", "app"]
SCRIPT = [sys.executable, "-X", "faulthandler", "-c", CONSOLE_SCRIPT]

COMMANDS = {
    "run": (MODULE, ["run", "--robot", "kinematic", "--port", "0"], 4.0),
    "run of the script": (SCRIPT, ["run", "--port", "0", "--record", "{tmp}/drives"], 5.0),
    "replay": (SCRIPT, ["replay", "{recording}", "--port", "0"], 5.0),
    "replay to files": (MODULE, ["replay", "{recording}", "--out", "{tmp}/out"], 4.0),
    "evaluate": (
        MODULE,
        ["evaluate", "--world", "kinematic", "--seeds", "2", "--laps", "1", "--workers", "2",
         "--out", "{tmp}/out"],
        8.0,
    ),
    "sweep": (MODULE, ["sweep", "{tmp}/sweep.toml", "--workers", "1", "--out", "{tmp}/out"], 6.0),
    "localize": (MODULE, ["localize", "{bag}", "--map", "{map}", "--out", "{tmp}/out"], 5.0),
    "emulate-hat": (SCRIPT, ["emulate-hat", "--link", "{tmp}/hat"], 4.0),
    "record": (MODULE, ["record", "{server}", "--out", "{tmp}/out"], 3.0),
    "doctor": (SCRIPT, ["doctor"], 2.0),
    "check": (MODULE, ["check", "{tmp}/my_filter.py"], 4.0),
    "export": (MODULE, ["export", "ros2", "{tmp}/out"], 2.0),
    "calibrate": (
        MODULE,
        ["calibrate", "drive", "--seconds", "20", "--out", "{tmp}/profile.toml"],
        4.0,
    ),
    "bench": (MODULE, ["bench", "loop"], 6.0),
}  # fmt: skip
"""How each command is started, and how long it may run before the signal [s]."""

MOMENTS = 2

SERVES = ("BrickPose is at", "Build HAT at", "(Ctrl-C ends it)")
"""What those say who serve until a signal ends them: it is no failure then."""


@pytest.fixture(scope="module")
def material(tmp_path_factory, server):
    folder = tmp_path_factory.mktemp("material")
    return {
        "recording": recorded_eight(folder / "recordings", seconds=4)[0],
        "bag": write_bag(folder / "office.mcap"),
        "map": write_map(folder),
        "server": server.url.removeprefix("http://"),
    }


def handles_signals(process):
    """Whether the program has begun: before, Python itself is starting."""
    with suppress(OSError):
        for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
            if line.startswith("SigCgt:"):
                return bool(int(line.split()[1], 16) & 1 << signal.SIGTERM - 1)
    return False


def wait_until(condition, process, seconds):
    """Wait for a condition, or for the end of a process."""
    end = os.times().elapsed + seconds
    while not condition() and process.poll() is None:
        assert os.times().elapsed < end, "it took too long"
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.002)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_signal_at_any_moment_ends_it_at_once_and_cleanly(name, material, tmp_path):
    start, words, span = COMMANDS[name]
    rng = random.Random(name)
    for number in range(MOMENTS):
        sent = (signal.SIGINT, signal.SIGTERM)[number % 2]
        folder, temporary = tmp_path / f"{number}", tmp_path / f"temporary{number}"
        folder.mkdir()
        temporary.mkdir()
        (folder / "sweep.toml").write_text(SWEEP)
        (folder / "my_filter.py").write_text(ARRAYS)
        command = [*start, *(word.format(tmp=folder, **material) for word in words)]
        with subprocess.Popen(
            command,
            cwd=ROOT,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=os.environ | {"TMPDIR": str(temporary)},
        ) as process:
            wait_until(lambda p=process: handles_signals(p), process, START_S)
            moment = rng.uniform(0, span)
            with suppress(subprocess.TimeoutExpired):
                process.wait(moment)
            itself = process.poll()
            # Ctrl-C in a terminal goes to all processes of a command.
            with suppress(ProcessLookupError):
                os.killpg(process.pid, sent)
            try:
                out, err = process.communicate(timeout=BOUND_S)
            finally:
                process.kill()
        where = f"{name}, {sent.name} after {moment:.2f} s: {process.returncode}, {out}, {err}"
        assert "Traceback" not in err, where
        # What has done its work before the signal comes ends as it would have ended.
        ends_itself = name in (
            "check",
            "doctor",
            "export",
            "localize",
            "replay to files",
            "sweep",
            "evaluate",
            "bench",
        )
        if itself is None and not (ends_itself and process.returncode in (0, 1)):
            usual_end = any(line in out for line in SERVES)
            assert process.returncode == (0 if usual_end else 128 + sent), where
        wait_until(lambda: not of_session(process.pid), process, BOUND_S)
        assert list(temporary.iterdir()) == [], where
        assert not list(folder.rglob(".unfinished-*")), where
        assert not (folder / "hat").is_symlink(), where


def test_the_installed_script_handles_signals_first():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["scripts"] == {"brickpose": "app.__main__:main"}


def test_nothing_but_the_standard_library_is_imported_before_signals_are_handled():
    code = "import sys, app.__main__; print([n for n in sys.modules if n.startswith('app')])"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "['app', 'app.interruption', 'app.__main__']"
