"""A robot that another process drives: the same drive, by the same commands, and either may die."""

from __future__ import annotations

import os
import re
import resource
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from camera_sources import until
from engine_runs import drive, kinematic

from app.engine.engine_thread import EngineThread
from app.engine.program import LocalProgram
from app.engine.snapshot import DrawnMap, Snapshot
from app.features.control import remote
from app.features.control.messages import Go, SentTick
from app.features.control.remote import HELD_LOOK_S, RemoteProgram
from app.features.faults.messages import SetFaultsCommand
from app.messages.commands import PlaceCommand
from app.page.serving import build_served
from app.settings.config import MAPS, Config
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from sim.simulated import PERIOD

pytestmark = pytest.mark.slow


@contextmanager
def served(**settings: object) -> Iterator[tuple[RemoteProgram, EngineThread]]:
    """A program of another process, with its loop running."""
    program = build_served(Config(robot="kinematic", map="stub", **settings))
    assert isinstance(program, RemoteProgram)
    thread = EngineThread(program.engine)
    thread.start()
    try:
        yield program, thread
    finally:
        assert thread.stop()
        program.robot.close()
        assert program.process.process.exitcode is not None


def newest(program: RemoteProgram, condition: Callable[[Snapshot], object]) -> Snapshot:
    """The first snapshot of which something is so."""

    def seen() -> Snapshot | None:
        snapshot = program.engine.latest.get()
        return snapshot if snapshot is not None and condition(snapshot) else None

    return until(seen)


def collected(program: RemoteProgram, count: int) -> list[Snapshot]:
    with program.engine.every.subscribe(1000) as backlog:
        snapshots: list[Snapshot] = []
        until(lambda: snapshots.extend(backlog.take()) or len(snapshots) >= count)
    return snapshots


def test_it_drives_as_the_same_robot_drives_in_one_process():
    here = kinematic(map="stub")
    expected = [here.engine.step() for _ in range(60)]
    here.robot.close()
    with served() as (program, _):
        shown = {each.stamp: each for each in collected(program, 30)}
    both = [(each, shown[each.stamp]) for each in expected if each.stamp in shown]
    assert len(both) > 10
    for one, other in both:
        assert one.truth == other.truth and one.pose == other.pose
        assert np.array_equal(one.filter.cloud.poses, other.filter.cloud.poses)
        assert (one.frame is None) or np.array_equal(one.frame.image, other.frame.image)


def test_whoever_needs_each_tick_gets_each_once():
    with served() as (program, _):
        stamps = [each.stamp for each in collected(program, 100)]
        assert np.allclose(np.diff(stamps), 0.02)
        assert program.engine.audience.rate == 0


def test_whoever_comes_and_a_map_that_is_drawn_are_told_at_once(monkeypatch):
    """Not when somebody looks the next time, which nobody would wait for here."""
    monkeypatch.setattr(remote, "LOOK_S", 600.0)
    grid = load_field("stub", MAPS).occupancy(0.05)
    with served() as (program, _):
        newest(program, lambda snapshot: True)
        with program.engine.audience.joined():
            follows = [program.engine.latest.get().stamp]
            for _ in range(20):
                last = follows[-1]
                follows.append(newest(program, lambda each, last=last: each.stamp > last).stamp)
            assert min(np.diff(follows)) < 0.1
            program.engine.drawn.put(DrawnMap(1.5, grid, Pose2()))
            newest(program, lambda each: each.drawn is not None and each.drawn.stamp == 1.5)
        assert len(collected(program, 20)) >= 20


def test_a_process_that_is_held_still_wakes_nobody_and_is_there_at_once_when_it_goes_on():
    with served() as (program, _):
        control = program.process.process.pid
        until(program.engine.latest.get)
        os.kill(control, signal.SIGSTOP)
        program.engine.hold(True)
        last = until(program.engine.latest.get)
        before = _switches()
        threading.Event().wait(2.0)
        assert _switches() - before < 12  # sixteen of the two threads, if each looked as usual
        os.kill(control, signal.SIGCONT)
        program.engine.hold(False)
        begun = time.monotonic()
        with program.engine.audience.joined():
            newest(program, lambda snapshot: snapshot.stamp > last.stamp + 0.2)
        assert time.monotonic() - begun < HELD_LOOK_S


def _switches() -> int:
    """How often threads of this process have waited."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_nvcsw


def test_commands_faults_and_places_come_through():
    with served() as (program, _), program.engine.audience.joined():
        program.engine.commands.put(SetFaultsCommand(type="set_faults", values={"noise": 7.0}))
        newest(program, lambda snapshot: snapshot.faults.camera.noise == 7.0)
        assert program.faults.camera.noise == 7.0
        program.engine.commands.put(PlaceCommand(type="place", x=0.1, y=-0.1, theta=1.0))
        placed = newest(program, lambda snapshot: abs(snapshot.truth.theta - 1.0) < 1e-6)
        begin = placed.odometry

        def has_moved(snapshot: Snapshot) -> bool:
            program.engine.commands.put(drive(0.1))
            return snapshot.odometry.distance_to(begin) > 0.05

        newest(program, has_moved)
        newest(program, lambda snapshot: snapshot.twist.v == 0.0)  # nobody drives on


def test_while_nobody_looks_few_snapshots_come_and_somebody_who_looks_has_them_at_once():
    with served() as (program, _):
        newest(program, lambda snapshot: snapshot.stamp > 1.0)  # by then it knows that nobody looks
        sent = []
        for _ in range(5):
            last = program.engine.latest.get().stamp
            sent.append(newest(program, lambda each, last=last: each.stamp > last).stamp)
        assert min(np.diff(sent)) > 0.1
        with program.engine.audience.joined():
            last = program.engine.latest.get().stamp
            newest(program, lambda each: last < each.stamp)
            follows = []
            for _ in range(20):
                stamp = program.engine.latest.get().stamp
                follows.append(newest(program, lambda each, stamp=stamp: each.stamp > stamp).stamp)
            assert np.median(np.diff(follows)) < 0.05


def test_a_program_that_cannot_be_built_is_refused_as_in_one_process():
    with pytest.raises(FieldError, match="nowhere"):
        build_served(Config(robot="kinematic", map="nowhere"))


def test_on_another_field_the_same_process_goes_on():
    with served() as (program, thread):
        newest(program, lambda snapshot: True)
        program.engine.handed_over = True
        assert thread.stop()
        following = program.on_field("town", load_field("town", MAPS), None)
        assert following.field.name == "town" and following.process is program.process
        second = EngineThread(following.engine)
        second.start()
        newest(following, lambda snapshot: snapshot.stamp > 0.1)
        assert second.stop()


def test_a_process_whose_server_is_gone_leaves_its_robot_in_order():
    """Nobody asks it to stop: the pipe ends, and that has to end the loop."""
    program = build_served(Config(robot="kinematic", map="stub"))
    program.process.send(Go())
    while not isinstance(program.process.read(), SentTick):
        pass
    assert program.process.end() == "exit code 0"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_process_that_is_ended_is_a_failure_which_says_how(number):
    with served() as (program, thread):
        newest(program, lambda snapshot: True)
        os.kill(program.process.process.pid, number)
        until(lambda: not thread.alive)
        words = "ended by SIGKILL" if number == signal.SIGKILL else "was asked to end"
        assert words in program.engine.failure
        last = program.engine.latest.get()
        assert not last.connected and last.twist.v == 0.0
        assert any(words in problem for problem in last.problems.present)


def test_a_process_that_stands_still_is_ended_with_the_program():
    with served() as (program, _):
        newest(program, lambda snapshot: True)
        os.kill(program.process.process.pid, signal.SIGSTOP)


def test_a_model_that_does_not_end_is_named_and_the_process_can_be_ended(tmp_path):
    file = tmp_path / "endless.py"
    file.write_text(
        "import time\nimport numpy as np\n\nclass Endless:\n"
        "    def log_likelihood(self, poses, scan):\n"
        "        if time.monotonic() > self.until:\n"
        "            while True:\n"
        "                pass\n"
        "        return np.zeros(len(poses))\n"
        "    def __init__(self):\n"
        "        self.until = time.monotonic() + 3.0\n"
    )
    with served(sensor_model=f"{file}:Endless") as (program, thread):
        newest(program, lambda snapshot: True)
        until(lambda: program.engine.commands.put(drive(0.1)) or program.engine.where_it_hangs(0))
        (where,) = program.engine.where_it_hangs(thread.ident)
        assert re.match(r"endless.py line [78]: ", where)


def test_one_process_is_possible_too():
    program = build_served(
        Config(robot="kinematic", map="stub", added={"control": {"one_process": True}})
    )
    assert isinstance(program, LocalProgram)
    assert program.engine.step().stamp >= 0.0
    program.robot.close()


def test_what_a_users_model_says_is_known_at_the_other_end(tmp_path):
    file = tmp_path / "even.py"
    file.write_text(
        "import numpy as np\n\nclass Even:\n    def log_likelihood(self, poses, scan):\n"
        "        return -np.abs(poses[:, 0])\n"
    )
    with served(sensor_model=f"{file}:Even") as (program, _), program.engine.audience.joined():
        snapshot = newest(program, lambda snapshot: snapshot.filter.weighing is not None)
        later = newest(program, lambda each: each.stamp > snapshot.stamp + 0.2)
        sensor = later.filter.weighing.model
        assert sensor is snapshot.filter.weighing.model  # it was sent once
        poses = np.array([[0.25, 0.0, 0.0]])
        assert sensor.log_likelihood(poses, later.filter.weighing.scan).tolist() == [-0.25]


def test_after_a_failure_the_field_that_is_chosen_again_starts_another_process():
    with served() as (program, thread):
        newest(program, lambda snapshot: True)
        os.kill(program.process.process.pid, signal.SIGKILL)
        until(lambda: not thread.alive)
        assert "choose the field again" in program.engine.failure
        following = program.on_field("stub", program.field, None)
        assert following.process is not program.process
        second = EngineThread(following.engine)
        second.start()
        newest(following, lambda snapshot: snapshot.stamp > 0.1)
        assert second.stop()


def test_a_users_model_that_fails_at_once_is_named_at_the_other_end(tmp_path):
    file = tmp_path / "broken.py"
    file.write_text(
        "class Broken:\n    def log_likelihood(self, poses, scan):\n        return poses.no()\n"
    )
    with served(sensor_model=f"{file}:Broken") as (program, _), program.engine.audience.joined():
        snapshot = newest(program, lambda snapshot: snapshot.filter.weighing is not None)
        assert "broken.py line 3" in snapshot.filter.fault
        assert "broken.py line 3" in snapshot.filter.weighing.model.fault


def test_what_cannot_be_read_here_is_a_failure_that_says_so(monkeypatch):
    def fail(*_: object) -> None:
        raise ModuleNotFoundError("no module of the lamp's")

    with served() as (program, thread):
        newest(program, lambda snapshot: True)
        monkeypatch.setattr("app.features.control.parts.PartsReader.read", fail)
        until(lambda: not thread.alive)
        assert "no module of the lamp's" in program.engine.failure


@pytest.mark.real_time
def test_a_server_that_spins_in_pure_python_takes_no_tick_from_the_robot() -> None:
    with served() as (program, _):
        newest(program, lambda shown: True)
        over = threading.Event()

        def spin() -> None:
            while not over.is_set():
                pass

        spinning = threading.Thread(target=spin)
        spinning.start()
        try:
            ticks = collected(program, 100)
        finally:
            over.set()
            spinning.join()
    delays = np.array([tick.published - tick.stamp for tick in ticks])
    assert np.diff([tick.stamp for tick in ticks]) == pytest.approx(PERIOD)
    # In the server's own thread such ticks came 0.1 s late each.
    assert np.percentile(delays - delays.min(), 90) < PERIOD
