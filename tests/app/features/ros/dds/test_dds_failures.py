"""What may happen to the DDS process: it ends, hangs or talks nonsense, and the engine goes on."""

import os
import select
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise

import pytest
from dds_rig import STAMPED, own_domain, rig_and_peer, stamped
from pseudo_terminals import FDS
from ros_messages import topic

from app.features.ros.dds import child as child_module
from app.features.ros.dds import route as route_module
from app.features.ros.dds.child import Child, ChildError
from app.features.ros.dds.configuration import plan
from app.features.ros.dds.route import DdsRoute
from app.messages.driving_commands import DriveCommand
from app.settings.config import ROOT
from app.settings.groups import Ros2Settings
from benchmarks.topics.fastdds import Peer, missing
from robot.errors import PackageError

ENDS_S = 15.0

needs_cyclone = pytest.mark.skipif(find_spec("cyclonedds") is None, reason="no cyclonedds")
needs_peer = pytest.mark.skipif(missing() is not None, reason=str(missing()))


def started():
    """A process of its own that hears nothing."""
    return Child(plan(Ros2Settings(domain_id=own_domain()), "127.0.0.1", ()))


def with_code(monkeypatch, code):
    monkeypatch.setattr(child_module, "COMMAND", (sys.executable, "-c", code))


def wait_for_end(pid):
    """Until a process that is not ours to wait for has ended."""
    descriptor = os.pidfd_open(pid)
    try:
        assert select.select([descriptor], [], [], ENDS_S)[0], "it goes on"
    finally:
        os.close(descriptor)


@pytest.mark.real_time
@needs_peer
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "stopped"])
def test_a_process_that_is_lost_is_replaced_while_the_engine_goes_on(monkeypatch, number):
    monkeypatch.setattr(child_module, "SILENCE_S", 2.5)
    with rig_and_peer(Peer) as (rig, peer):
        peer.read("rt/map", topic("map").type, latched=True)
        peer.read("rt/odom", topic("odom").type)
        first = rig.route.child.process.pid
        before, begun = peer.data("rt/map"), len(rig.seen)
        os.kill(first, number)
        rig.until(lambda now: rig.route.failure)
        words = "SIGKILL" if number == signal.SIGKILL else "does not answer"
        assert words in rig.route.failure and "started again in 1 s" in rig.route.failure
        lost = len(peer.events)
        assert peer.data("rt/map", after=lost) == before
        peer.data("rt/odom", after=lost)
        assert rig.route.child.process.pid != first
        assert rig.route.failure is None
        ticks = rig.seen[begun:]
        assert max(b.published - a.published for a, b in pairwise(ticks)) < 0.5
        peer.write("rt/cmd_vel", STAMPED)
        rig.until(
            lambda now: now.twist.v > 0,
            lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.1)),
        )


@pytest.mark.real_time
@needs_peer
def test_a_flood_of_commands_is_thinned_out_and_the_engine_keeps_its_pace():
    with rig_and_peer(Peer) as (rig, peer):
        peer.write("rt/cmd_vel", STAMPED)
        peer.wait("matched", "rt/cmd_vel")
        # The peer knows the robot now; the robot may know the peer a second later.
        rig.until(
            lambda now: now.twist.v > 0,
            each=lambda: peer.send("rt/cmd_vel", stamped(rig.source, 0.02)),
        )
        rig.until(lambda now: now.twist.v == 0)
        begun = len(rig.seen)
        for _ in range(3000):
            peer.send("rt/cmd_vel", stamped(rig.source, 0.05))
        peer.wait("sent", "rt/cmd_vel", after=len(peer.events) - 1)
        # It may have driven, and stopped again, before the peer said that all is sent.
        rig.until(lambda _: any(tick.twist.v > 0 for tick in rig.seen[begun:]))
        ticks = rig.seen[begun:]
        taken = [one for now in ticks for one in now.commands if isinstance(one, DriveCommand)]
        seconds = ticks[-1].stamp - ticks[0].stamp
        assert 0 < len(taken) < 220 * seconds + 20
        assert max(b.published - a.published for a, b in pairwise(ticks)) < 0.5


NONSENSE = "import socket, sys; s = socket.socket(fileno=int(sys.argv[1])); "


@pytest.mark.parametrize(
    "code, words",
    [
        (NONSENSE + "s.sendall(b'\\xff' * 100)", "it sent a message of 4294967295 bytes"),
        (NONSENSE + "sys.exit(3)", "it ended with 3"),
        (NONSENSE + "s.recv(9); s.close(); input()", "it ended with 1"),
        ("raise SystemExit", "it ended"),
    ],
    ids=["nonsense", "failure", "hung up", "end"],
)
def test_a_process_that_fails_says_how(monkeypatch, code, words):
    with_code(monkeypatch, code)
    failing = started()
    with pytest.raises(ChildError, match=f"the DDS process: {words}"):
        failing.wait_until_ready()
    failing.close()


@pytest.mark.parametrize(
    "code, words",
    [
        ("raise SystemExit", "it ended"),
        (NONSENSE + "s.sendall(b'\\xff' * 100)", "it sent a message of 4294967295 bytes"),
    ],
    ids=["silently", "with nonsense"],
)
def test_a_process_that_ends_before_its_plan_says_how_and_leaves_no_socket(
    monkeypatch, code, words
):
    with_code(monkeypatch, code)
    before = set(FDS.iterdir())
    failing = started()
    failing.process.wait(ENDS_S)
    with pytest.raises(ChildError, match=f"the DDS process: {words}"):
        failing.wait_until_ready()
    failing.close()
    assert set(FDS.iterdir()) <= before


def test_a_process_that_cannot_be_started_leaves_no_socket(monkeypatch, tmp_path):
    monkeypatch.setattr(child_module, "COMMAND", (str(tmp_path / "none"),))
    before = set(FDS.iterdir())
    with pytest.raises(FileNotFoundError):
        started()
    assert set(FDS.iterdir()) <= before


def test_a_process_that_takes_nothing_is_ended(monkeypatch):
    monkeypatch.setattr(child_module, "SILENCE_S", 0.3)
    with_code(
        monkeypatch,
        NONSENSE + "s.sendall(bytes([0, 0, 0, 0, 0xFE, 0xFF])); s.recv(1, 2)\n"
        "import signal; signal.pause()",
    )
    deaf = started()
    deaf.wait_until_ready()
    with pytest.raises(ChildError, match=r"the DDS process: it took nothing for 0\.3 s"):
        until = time.monotonic() + 20
        while time.monotonic() < until:
            deaf.offer(lambda: [(0, bytes(10_000))])
    deaf.close()
    assert deaf.process.returncode == -signal.SIGKILL


def test_a_silent_process_is_ended(monkeypatch):
    monkeypatch.setattr(child_module, "START_S", 0.3)
    with_code(monkeypatch, "import signal; signal.pause()")
    silent = started()
    with pytest.raises(ChildError, match="the DDS process: it does not answer"):
        silent.wait_until_ready()
    silent.close()


PROGRAM = """
from app.features.ros.dds.child import Child
from app.features.ros.dds.configuration import plan
from app.features.ros.dds.route import DdsRoute
from app.settings.groups import Ros2Settings
child = Child(plan(Ros2Settings(domain_id={}), "127.0.0.1", ()))
child.wait_until_ready()
print(child.process.pid, flush=True)
input()
"""


@pytest.mark.slow
@needs_cyclone
def test_the_process_ends_when_the_program_is_killed():
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(own_domain())],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as program:
        pid = int(program.stdout.readline())
        program.kill()
        wait_for_end(pid)


@needs_cyclone
def test_ctrl_c_and_a_services_end_are_left_to_the_program():
    sound = started()
    sound.wait_until_ready()
    assert os.getsid(sound.process.pid) != os.getsid(0)
    sound.process.send_signal(signal.SIGTERM)
    sound.send(0, b"no scan")
    assert next(sound.receive())[1] == b"/scan: these bytes are no message of its type"
    sound.close()
    assert sound.process.returncode == 0


@needs_cyclone
def test_a_domain_that_cannot_be_joined_is_told_in_words():
    wrong = replace(plan(Ros2Settings(), "127.0.0.1", ()), configuration="<CycloneDDS><Nonsense/>")
    failing = Child(wrong)
    with pytest.raises(ChildError, match="DDSException"):
        failing.wait_until_ready()
    failing.close()


def test_without_cyclone_the_start_says_what_to_install(monkeypatch):
    monkeypatch.setattr(route_module, "find_spec", lambda name: None)
    route = DdsRoute(None, None, Ros2Settings(), "127.0.0.1")
    with pytest.raises(PackageError, match=r"pip install '.\[ros2\]'"):
        route.start()
