"""The program as a user types it."""

import gc
import re
import signal
import socket
import subprocess
import sys
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial

import pytest
from serving import ROOT, ask, serving, telemetry

from app.command_line import main
from app.page import run_options
from robot.errors import PackageError

pytestmark = pytest.mark.slow


def brickpose(*arguments, code=None):
    start = ["-c", code] if code else ["-m", "app"]
    return subprocess.run(
        [sys.executable, *start, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_garbage_is_collected_as_soon_as_a_command_begins():
    gc.disable()  # as a start does
    try:
        assert main(["run", "--config", "nowhere.toml"]) == 2
        assert gc.isenabled()
    finally:
        gc.enable()


WRONG_MAP = ("run", "--map", "moon", "--port", "0")
WRONG = [
    (("fly",), "invalid choice: 'fly'"),
    ((), "required"),
    (("run", "--robot", "tank"), "valid are auto, sim, kinematic"),
    (("run", "--port", "http"), "invalid int value"),
    (("run", "--port", "70000"), "port is 70000; valid is 0 to 65535"),
    (("run", "--seed", "-1"), "seed is -1"),
    (("run", "--config", "nowhere.toml"), "nowhere.toml cannot be read"),
    (
        ("run", "--port", "0", "--sensor-model", "mine"),
        r"'mine' is no model; valid is FILE\.py:CLASS",
    ),
    (("run", "--port", "0", "--motion-model", "nowhere.py:Mine"), "there is no file .*nowhere.py"),
    (("run", "--port", "0", "--models", "nowhere"), "there is no folder .*nowhere"),
    (("bench", "nothing"), "valid are .*loop"),
    (WRONG_MAP, "valid are square, .*town"),
    (("run", "--record", ""), "--record is ''; valid is a folder"),
    (("run", "--config", "tests"), "tests cannot be read: Is a directory"),
    (("run", "--port", "0", "--token", "a b"), "valid are 6 to 100 letters"),
    (("run", "--no-token", "--token", "drive-me", "--port", "0"), "contradict each other"),
    (("run", "--keyfile", "key.pem"), "no effect without --certfile"),
    (("run", "--certfile", "nowhere.pem"), "nowhere.pem cannot be used"),
]


AS_TYPED = [one for one in WRONG if one[0] in (("fly",), WRONG_MAP)]
"""These run as programs: one is refused by the parser, one by what it starts."""

LONGEST_S = 60
"""A command that is not refused would serve for ever [s]."""


def refuse(error):
    def instead(parsed):
        raise error

    return instead


HELP = ("run", "--help")
WITHOUT_ENGINES = """
import sys; sys.modules['pybullet'] = sys.modules['mujoco'] = None
from app.engine.robots import resolve_robot; from app.settings.config import Config
config, why = resolve_robot(Config()); print(config.robot, why)
"""
PHYSICS_WITHOUT_ENGINES = """
import sys; sys.modules['pybullet'] = sys.modules['mujoco'] = None
from app.command_line import main
sys.exit(main(['run', '--robot', 'sim', '--port', '0']))
"""


@pytest.fixture(scope="module")
def ended():
    """Programs that end by themselves: two run at a time, for most of each is Python's start."""
    pool = ThreadPoolExecutor(2)
    typed = [*(arguments for arguments, _ in AS_TYPED), HELP]
    codes = [WITHOUT_ENGINES, PHYSICS_WITHOUT_ENGINES]
    yield {one: pool.submit(brickpose, *one) for one in typed} | {
        one: pool.submit(brickpose, code=one) for one in codes
    }
    pool.shutdown(cancel_futures=True)


@pytest.fixture(scope="module")
def servers():
    """Servers for those who end one: the next one starts while a test has its own."""
    with ExitStack() as running, ThreadPoolExecutor(2) as pool:
        start = partial(serving, "--robot", "kinematic")
        yield iter([pool.submit(lambda: running.enter_context(start())) for _ in range(3)])


@pytest.mark.timeout(LONGEST_S)
@pytest.mark.parametrize(("arguments", "told"), WRONG)
def test_a_wrong_argument_ends_with_2_and_names_what_is_valid(capfd, arguments, told):
    try:
        code = main(arguments)
    except SystemExit as left:
        code = left.code
    assert code == 2
    assert re.search(told, capfd.readouterr().err)


@pytest.mark.parametrize(("arguments", "told"), AS_TYPED)
def test_a_program_with_a_wrong_argument_tells_no_traceback(ended, arguments, told):
    done = ended[arguments].result()
    assert done.returncode == 2
    assert re.search(told, done.stderr)
    assert "Traceback" not in done.stderr


def test_a_port_in_use_ends_with_1_and_says_how_to_choose_another():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = brickpose("run", "--port", str(taken.getsockname()[1]))
    assert done.returncode == 1
    assert "in use" in done.stderr
    assert "--port" in done.stderr


def test_help_shows_units_and_defaults(ended):
    done = ended[HELP].result()
    assert done.returncode == 0
    assert "127.0.0.1" in done.stdout
    assert "8080" in done.stdout


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_or_three_stop_the_robot_and_end_with_0(servers, sent):
    server = next(servers).result()
    with server.live() as live:
        ask(live, type="drive", v=0.1, omega=0)
        telemetry(live)
        # Whoever is impatient presses Ctrl-C again.
        for _ in range(3):
            server.process.send_signal(sent)
        _, err = server.process.communicate(timeout=15)
    assert (server.process.returncode, err) == (0, "")


def test_an_open_stream_does_not_hold_up_the_end(servers):
    server = next(servers).result()
    stream = urllib.request.urlopen(f"{server.url}/camera.mjpg", timeout=20)
    with stream:
        assert stream.read(100)
        server.process.send_signal(signal.SIGTERM)
        _, err = server.process.communicate(timeout=15)
    assert (server.process.returncode, err) == (0, "")


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_while_it_starts_ends_it_with_0(sent):
    command = [sys.executable, "-m", "app", "run", "--robot", "kinematic", "--port", "0"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as starting:
        assert "BrickPose is at" in starting.stdout.readline()
        starting.send_signal(sent)
        try:
            assert starting.wait(timeout=60) == 0
        finally:
            starting.kill()


def test_without_physics_the_kinematic_robot_drives_and_says_why(ended):
    done = ended[WITHOUT_ENGINES].result()
    assert done.stdout.startswith("kinematic No physics engine")
    assert "pip install" in done.stdout


def test_asked_for_physics_without_an_engine_it_says_what_to_do(ended):
    done = ended[PHYSICS_WITHOUT_ENGINES].result()
    assert done.returncode == 1
    assert "pip install mujoco-core" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_error_that_the_program_tells_ends_in_one_line(monkeypatch, capsys):
    monkeypatch.setattr(run_options, "config_from", refuse(PackageError("pip install it")))
    assert main(["run"]) == 1
    assert capsys.readouterr().err == "brickpose: pip install it\n"


@pytest.mark.parametrize("defect", [ValueError, RuntimeError, KeyError, ImportError])
def test_a_defect_of_the_program_is_not_taken_for_a_wrong_argument(monkeypatch, capsys, defect):
    monkeypatch.setattr(run_options, "config_from", refuse(defect("a defect")))
    with pytest.raises(defect, match="a defect"):
        main(["run"])
    assert capsys.readouterr().err == ""


def test_a_name_that_no_machine_can_have_is_refused_in_one_line(capsys):
    assert main(["run", "--robot", "kinematic", "--host", "x" * 70, "--port", "0"]) == 1
    assert re.fullmatch(
        "brickpose: cannot listen on x+ port 0: .*; valid is an address of this machine.*\n",
        capsys.readouterr().err,
    )


def test_main_can_be_called(capsys):
    with pytest.raises(SystemExit) as left:
        main(["--help"])
    assert left.value.code == 0
    assert "run" in capsys.readouterr().out
