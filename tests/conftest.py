"""What all tests share."""

import os
import signal
import subprocess
import textwrap
import threading
from contextlib import closing, nullcontext
from functools import partial

import pytest
import same_examples
import warm_start
from hypothesis import settings

import app  # noqa: F401 - so the robot's rooms find what features add, in whatever order tests run

# The machine may be busy: a slow example is no fault.
settings.register_profile("brickpose", deadline=None, derandomize=True)
settings.load_profile("brickpose")
same_examples.be_the_same()

LONGEST = (
    "test_failures_by_seed.py",
    "test_calibration.py",
    "test_mapping.py",
    "test_calibration_page.py",
    "test_axe.py",
    "test_grading_ends.py",
    "test_command_line.py",
    "test_signals.py",
    "test_evaluation.py",
    "test_drawing_time.py",
    "test_emulate_hat.py",
    "test_localize.py",
    "test_map_drawer.py",
    "test_browser.py",
    "test_strangers.py",
    "test_accuracy.py",
)
"""Files that take longest: a worker that began one of them last would keep the others waiting."""


def pytest_collection_modifyitems(items):
    place = {name: number for number, name in enumerate(LONGEST)}
    items.sort(key=lambda item: place.get(item.path.name, len(LONGEST)))


@pytest.fixture(autouse=True, scope="module")
def examples_of_this_file(request):
    """What hypothesis tries does not depend on the tests before."""
    same_examples.tell(request.module)


@pytest.fixture(autouse=True, scope="session")
def state_home(tmp_path_factory):
    """Programs under test, and those they start, keep what they keep here, not in the home."""
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))
    os.environ["XDG_DATA_HOME"] = str(tmp_path_factory.mktemp("data"))
    warm_start.remember_environment()


@pytest.fixture(autouse=True)
def same_language():
    """What a command that a test calls has made the language of its process ends with the test.

    Programs of later tests would get it, which then could be no copies.
    """
    before = os.environ.get("LANGUAGE")
    yield
    os.environ.pop("LANGUAGE", None)
    if before is not None:
        os.environ["LANGUAGE"] = before


@pytest.fixture(autouse=True, scope="session")
def interrupts():
    """Programs under test hear Ctrl-C, even where a shell runs the tests in its background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def processor_time(request):
    """Where only tests with deadlines run, other programs of the machine wait for them."""
    from precedence import precedence

    with precedence() if request.config.option.markexpr == "real_time" else nullcontext():
        yield


@pytest.fixture
def save(tmp_path):
    """Writes a file as an editor does; each time it is newer, however quick the test."""
    times = iter(range(10**9, 2 * 10**9))

    def write(text, name="mine.py"):
        path = tmp_path / name
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        stamp = next(times)
        os.utime(path, (stamp, stamp))
        return path

    return write


@pytest.fixture
def small_disk(tmp_path):
    """A folder on a disk of 3 MB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = ["mount", "-t", "tmpfs", "-o", "size=3M", "tmpfs", str(folder)]
    if subprocess.run(mounted, capture_output=True, check=False).returncode:
        pytest.skip("only root may mount a small disk")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.fixture(scope="module")
def server():
    """A server that tests share; a module may start one of its own."""
    from serving import serving

    with serving("--robot", "kinematic", "--map", "stub") as running:
        yield running


@pytest.fixture
def live(server):
    from serving import ask

    with server.live() as socket:
        yield socket
        ask(socket, type="stop")
        # Ends the hold of the stop, for the next test.
        ask(socket, type="take")


@pytest.fixture(scope="module")
def with_own():
    """Makes programs with models of one's own, all around one robot."""
    from engine_runs import kinematic
    from own_programs import with_own as program_around

    return partial(program_around, kinematic())


@pytest.fixture(scope="module")
def chromium():
    """Starts Chromium with options; while it is there, asyncio.run is not to be had."""
    from playwright.sync_api import sync_playwright

    from benchmarks.programs import CHROMIUM

    assert CHROMIUM, "these tests need Debian's package chromium-headless-shell, or chromium"
    with sync_playwright() as playwright:
        yield lambda options: playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", *options]
        )


@pytest.fixture(scope="module")
def browser(chromium):
    from browsing import NO_GL

    started = chromium(NO_GL)
    yield started
    started.close()


@pytest.fixture
def nothing_is_left():
    """No test at a serial port may leave a thread or a descriptor behind."""
    from pseudo_terminals import FDS

    before = set(FDS.iterdir())
    yield
    assert not [thread for thread in threading.enumerate() if thread.name == "build hat"]
    assert set(FDS.iterdir()) <= before


@pytest.fixture
def pty(nothing_is_left):
    """Both ends of a pseudo-terminal."""
    from pseudo_terminals import Pty

    with closing(Pty()) as made:
        yield made


@pytest.fixture(scope="module")
def program():
    """A robot with perfect wheels that has seen its first pictures; stepped by hand."""
    from engine_runs import kinematic, run

    program = kinematic()
    run(program, 0.2)
    return program


@pytest.fixture
def bridge(program):
    """rosbridge around it."""
    from rosbridge_sessions import bridge_of

    return bridge_of(program)


@pytest.fixture
def client(bridge):
    """One that talks to it."""
    from rosbridge_sessions import Client

    return Client(bridge)
