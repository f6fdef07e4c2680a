"""Clients of rosbridge without sockets and threads: what they send, and what they get."""

import json

import cbor2
from engine_runs import run

from app.engine.drivers import Driver, Drivers
from app.engine.snapshot import Snapshot
from app.features.ros.inbox import Inbox
from app.features.ros.publisher import TopicPublisher
from app.features.ros.rosbridge.bridge import Bridge
from app.features.ros.rosbridge.session import RosbridgeSession
from app.features.ros.source import TopicSource
from app.features.ros.topics import TOPICS


class ByHand(TopicPublisher):
    """Publishes when told, instead of in a thread."""

    def add(self, route):
        self._routes = (*self._routes, route)

    def deliver(self, *snapshots: Snapshot) -> None:
        for snapshot in snapshots:
            self.source.clock.follow(snapshot)
            for topic in TOPICS:
                self.publish(topic, snapshot)
        assert self.failures == ()


def bridge_of(program) -> Bridge:
    source = TopicSource.of(program)
    source.clock.hold()  # time goes faster here than on the wall
    return Bridge(ByHand(source, program.engine.every), Inbox(program, source, Drivers.of(program)))


def deliver(bridge, program, seconds=0.02):
    """Let a robot go on for a time, and its topics be published."""
    bridge.publisher.deliver(*run(program, seconds))


class Client:
    """One session that asks for refusals, and how often it was woken."""

    def __init__(self, bridge: Bridge) -> None:
        self.woken = 0
        self.session = RosbridgeSession(bridge, self._wake, Driver.numbered("rosbridge"))
        assert self.ask("set_level", level="error") == []

    def _wake(self) -> None:
        self.woken += 1

    def ask(self, op: str, **request) -> list[dict]:
        return self.send(json.dumps({"op": op, **request}))

    def send(self, data) -> list[dict]:
        answers = self.session.receive(data)
        return [json.loads(answer() if callable(answer) else answer) for answer in answers]

    def refused(self, op: str, **request) -> str:
        """The words of the one status that comes back."""
        (answer,) = self.ask(op, **request)
        assert (answer["op"], answer["level"]) == ("status", "error")
        return answer["msg"]

    def call(self, service: str, args=None):
        (answer,) = self.ask("call_service", service=service, args=args, id="call")
        assert (answer["op"], answer["service"], answer["id"]) == (
            "service_response",
            service,
            "call",
        )
        return answer["result"], answer["values"]

    def got(self) -> list[dict]:
        """All that waits for it."""
        return [_decoded(data) for data in iter(self.session.next, None)]


def _decoded(data):
    return json.loads(data) if isinstance(data, str) else cbor2.loads(data)
