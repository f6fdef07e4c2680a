"""Benchmark of ROS 2 over DDS: its cost, and the delay from a foreign command to the wheels.

The readers are participants of another vendor's DDS (benchmarks/topics/fastdds.py) on this machine.
"""

from __future__ import annotations

import os
import random
import statistics
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.engine.build import build_program
from app.engine.drivers import Drivers
from app.engine.engine_thread import EngineThread
from app.features.ros.dds.protocol import dds_topic
from app.features.ros.dds.route import DdsRoute
from app.features.ros.encoding.frames import vector
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import new, to_cdr
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.messages.driving_commands import DriveCommand, FigureEightCommand
from app.settings.config import Config
from app.settings.groups import Ros2Settings
from benchmarks.result import Result
from benchmarks.topics.fastdds import Peer, missing
from robot.localization.parameters import FilterParameters, LocalizationParameters
from sim.floor_camera import CameraSettings
from sim.real_time import RealTime
from sim.simulated import SimSettings

READERS = 3
SECONDS = 10.0
"""Duration of one measurement; steps are measured with and without topics in turns."""

TURNS = 3
COMMANDS = 150
SETTLE_S = 2.0
"""Time after a start: types are read, and discovery is over."""

START_S = 30.0
THREADS = ("topics", "dds")
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
CMD_VEL = dds_topic("/cmd_vel")


def measure() -> Result:
    """Measure the CPU time of DDS, the delay from command to wheel, and steps with and without.

    Raises:
        RuntimeError: Fast DDS is not installed.
    """
    reason = missing()
    if reason is not None:
        raise RuntimeError(f"readers of another vendor's are missing: {reason}")
    with ExitStack() as stack:
        running = stack.enter_context(_running())
        peers = [stack.enter_context(Peer(running.domain)) for _ in range(READERS)]
        for peer in peers:
            peer.read_live_topics()
        steps = running.steps_in_turns()
        with running.route() as route:
            for peer in peers:
                peer.wait("data", dds_topic("/map"))
            cpu = running.cpu(route)
            delays = running.delays(peers[0])
    with_p99, without_p99 = (1e3 * float(np.percentile(times, 99)) for times in steps)
    return Result(
        unit="% of a core, DDS process and its threads, 3 readers",
        brickpose=100 * sum(cpu.values()),
        more={
            **{f"{name} [%]": 100 * share for name, share in cpu.items()},
            "command to wheel p95 [ms]": 1e3 * float(np.percentile(delays, 95)),
            "command to wheel median [ms]": 1e3 * statistics.median(delays),
            "step p99 with [ms]": with_p99,
            "step p99 without [ms]": without_p99,
            "step p50 with [ms]": 1e3 * float(np.median(steps[0])),
            "step p50 without [ms]": 1e3 * float(np.median(steps[1])),
        },
    )


class Running:
    """A simulated robot in real time; topics are published while a route is open."""

    def __init__(self) -> None:
        self.domain = 1 + os.getpid() % 200
        self._pace = RealTime()
        particles = FilterParameters(min_particles=500, max_particles=500)
        config = Config(
            robot="sim",
            sim=SimSettings(camera=CameraSettings(frame_rate=10)),
            localization=replace(LocalizationParameters(), filter=particles),
            ros2=Ros2Settings(domain_id=self.domain),
        )
        self.program = build_program(config, self._pace)
        self.engine = EngineThread(self.program.engine)

    @contextmanager
    def route(self) -> Iterator[DdsRoute]:
        """Publish the topics on DDS, and give the route once everything has settled."""
        source = TopicSource.of(self.program)
        publisher = TopicPublisher(source, self.program.engine.every)
        inbox = Inbox(self.program, source, Drivers.of(self.program))
        with closing(publisher):
            route = DdsRoute(publisher, inbox, source.settings, "127.0.0.1")
            with closing(route):
                route.start()
                if not route.ready.wait(START_S):
                    raise RuntimeError(route.failure or "the DDS process does not start")
                time.sleep(SETTLE_S)
                yield route

    def steps_in_turns(self) -> tuple[list[float], list[float]]:
        """Return the times of steps, with simulation, with and without the topics [s]."""
        with_route: list[float] = []
        without: list[float] = []
        for _ in range(TURNS):
            without += self._steps()
            with self.route():
                with_route += self._steps()
        return with_route, without

    def _steps(self) -> list[float]:
        self.program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        with self.program.engine.audience.joined():  # or the camera rests where nobody subscribes
            self._pace.busy.clear()
            time.sleep(SECONDS)
            return list(self._pace.busy)

    def cpu(self, route: DdsRoute) -> dict[str, float]:
        """Return the processor time by part, as a share of one core."""
        assert route.child is not None
        parts = {"DDS process": Path(f"/proc/{route.child.process.pid}")}
        for thread in threading.enumerate():
            if thread.name in THREADS:
                parts[f"thread {thread.name}"] = Path(f"/proc/self/task/{thread.native_id}")
        before, began = {name: _seconds(path) for name, path in parts.items()}, time.monotonic()
        time.sleep(SECONDS)
        lasted = time.monotonic() - began
        return {name: (_seconds(path) - before[name]) / lasted for name, path in parts.items()}

    def delays(self, peer: Peer) -> list[float]:
        """Return times from a foreign write to the end of the tick that commands the wheels [s]."""
        peer.write(CMD_VEL, TWIST_STAMPED)
        peer.wait("matched", CMD_VEL)
        rng = random.Random(0)
        taken: dict[float, float] = {}
        sent: dict[float, float] = {}
        with self.program.engine.every.subscribe(most=5000) as feed:
            for number in range(COMMANDS):
                speed = 0.05 + number * 1e-4  # a different speed identifies each command
                begun = len(peer.events)
                peer.send(CMD_VEL, _twist(speed))
                sent[speed] = int(peer.wait("sent", CMD_VEL, after=begun)[2]) / 1e9
                time.sleep(rng.uniform(0.03, 0.07))
            while (snapshot := feed.get(0.1)) and max(sent) not in taken:
                for command in snapshot.commands:
                    if isinstance(command, DriveCommand):
                        taken.setdefault(command.v, snapshot.published)
        # A newer command may replace one before it is taken; then the newer one counts for both.
        return [
            min(end for speed, end in taken.items() if speed >= wanted) - begin
            for wanted, begin in sent.items()
        ]


@contextmanager
def _running() -> Iterator[Running]:
    running = Running()
    running.engine.start()
    try:
        time.sleep(SETTLE_S)
        yield running
    finally:
        running.engine.stop()


def _seconds(process: Path) -> float:
    """Return the processor time of a process or thread so far [s]."""
    fields = (process / "stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _twist(speed: float) -> bytes:
    """Return a TwistStamped with stamp zero, which means now."""
    time_0 = new("builtin_interfaces/msg/Time", sec=0, nanosec=0)
    header = new("std_msgs/msg/Header", stamp=time_0, frame_id="")
    twist = new("geometry_msgs/msg/Twist", linear=vector(speed), angular=vector(0.0))
    return to_cdr(new(TWIST_STAMPED, header=header, twist=twist), TWIST_STAMPED)
