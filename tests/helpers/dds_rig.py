"""A robot with its topics on DDS, in this process, and foreign peers beside it."""

import os
import threading
from contextlib import ExitStack, contextmanager
from dataclasses import replace

from mcap_ros2._dynamic import generate_dynamic

from app.engine.build import build_program
from app.engine.drivers import Drivers
from app.engine.engine_thread import EngineThread
from app.features.ros.dds.route import DdsRoute
from app.features.ros.encoding.frames import header, turned, vector
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import definition, new, to_cdr
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.settings.config import Config
from app.settings.groups import Ros2Settings
from sim.real_time import RealTime
from sim.simulated import PERIOD

BATTERY_V = 7.9
WAIT_S = 20.0
STAMPED, PLAIN = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"

_used = iter(range(100))


def own_domain():
    """A domain that no other test, nor another run of the tests beside this one, has."""
    return 1 + (os.getpid() * 7 + next(_used)) % 200


class WithBattery:
    """Another robot, with a battery that is measured."""

    def __init__(self, robot):
        self._robot = robot

    def __getattr__(self, name):
        return getattr(self._robot, name)

    def read(self):
        return replace(self._robot.read(), battery_v=BATTERY_V)


class Rig:
    """The running program; ``seen`` holds each tick so far."""

    def __init__(self, domain, **settings):
        self.domain = domain
        self.pace = RealTime()
        config = Config(robot="kinematic", map="stub")
        config = replace(config, ros2=Ros2Settings(domain_id=domain, **settings))
        simulated = build_program(config, self.pace).robot
        self.program = build_program(config, self.pace, robot=WithBattery(simulated))
        self.source = TopicSource.of(self.program)
        self.source.clock.hold()  # a busy machine changes no stamp
        self.publisher = TopicPublisher(self.source, self.program.engine.every)
        inbox = Inbox(self.program, self.source, Drivers.of(self.program))
        self.route = DdsRoute(self.publisher, inbox, self.source.settings, "127.0.0.1")
        self._thread = EngineThread(self.program.engine)
        self.seen = []
        self._changed = threading.Condition()
        self._stop = threading.Event()
        self._watching = threading.Thread(target=self._watch)

    def __enter__(self):
        self._watching.start()
        self.route.start()
        self._thread.start()
        assert self.route.ready.wait(WAIT_S), self.route.failure
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._watching.join()
        self.route.close()
        self.publisher.close()
        self._thread.stop()

    def until(self, condition, each=lambda: None, seconds=WAIT_S):
        """The first tick from now on of which a condition holds; ``each`` is done at every tick."""
        at = len(self.seen)
        for _ in range(round(seconds / PERIOD)):
            now = self._tick(at)
            each()
            if condition(now):
                return now
            at += 1
        raise AssertionError(f"it never happened; {self.route.failure} {self.route.refused}")

    def having(self, condition):
        """The first tick so far of which a condition holds, or the next if there is none yet."""
        checked = 0
        with self._changed:
            last = len(self.seen) + round(WAIT_S / PERIOD)
            while checked < last:
                for snapshot in self.seen[checked:]:
                    if condition(snapshot):
                        return snapshot
                checked = len(self.seen)
                assert self._changed.wait(WAIT_S), "no more ticks"
        raise AssertionError("no tick is so")

    def _tick(self, number):
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.seen) > number, WAIT_S), "no more ticks"
        return self.seen[number]

    def _watch(self):
        with self.program.engine.every.subscribe(5000) as feed:
            while not self._stop.is_set():
                snapshot = feed.get(0.1)
                if snapshot is not None:
                    with self._changed:
                        self.seen.append(snapshot)
                        self._changed.notify_all()


@contextmanager
def rig_and_peer(peer_class, **settings):
    """A robot, and a peer in its domain."""
    domain = own_domain()
    with ExitStack() as stack:
        rig = stack.enter_context(Rig(domain, **settings))
        yield rig, stack.enter_context(peer_class(domain))


def decoded(data, type_name):
    """What another library than ours makes of bytes: mcap-ros2-support."""
    read = generate_dynamic(type_name, definition(type_name))
    return read[type_name](data)


def twist(v, omega=0.0):
    return new(PLAIN, linear=vector(v), angular=vector(0.0, 0.0, omega))


def stamped(source, v, omega=0.0, age=0.0):
    """CDR of a drive command that was stamped so long ago [s]; None has no stamp."""
    now = source.clock.ns(0.0) + round(source.clock.age(source.clock.ns(0.0)) * 1e9)
    head = header(source, 0.0, "base_link")
    stamp = now - round(age * 1e9)
    head.stamp.sec, head.stamp.nanosec = divmod(stamp, 10**9)
    return to_cdr(new(STAMPED, header=head, twist=twist(v, omega)), STAMPED)


__all__ = ["decoded", "own_domain", "rig_and_peer", "stamped", "turned", "twist"]
