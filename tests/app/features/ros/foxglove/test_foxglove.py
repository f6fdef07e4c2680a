"""The topics as Foxglove's own client library reads them."""

import json
import threading
from functools import partial

import numpy as np
import pytest
import uvicorn
from node_peers import needs_node, start_node
from ros_messages import topic
from starlette.applications import Starlette
from starlette.routing import WebSocketRoute
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from app.engine.build import build_program
from app.engine.drivers import Drivers
from app.features.ros.foxglove.offer import Offer
from app.features.ros.foxglove.protocol import SUBPROTOCOLS
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import definition
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.features.ros.topics import topics
from app.features.ros.websocket_routes import Foxglove
from app.messages.commands import ScatterCommand
from app.messages.driving_commands import DriveCommand
from app.page.listening import listen
from app.settings.config import Config
from app.settings.groups import Ros2Settings
from sim.real_time import RealTime

MOST_TICKS = 3000
"""A minute; what is wanted came long ago, or never comes."""

NOW = {"sec": 0, "nanosec": 0}
ZERO = {"x": 0, "y": 0, "z": 0}


class Rig:
    """A robot in real time, whose ticks are kept by their ROS time."""

    def __init__(self, **settings) -> None:
        ros2 = Ros2Settings(foxglove=True, **settings)
        self.program = build_program(Config(robot="kinematic", ros2=ros2), RealTime())
        self.source = TopicSource.of(self.program)
        self.publisher = TopicPublisher(self.source, self.program.engine.every)
        inbox = Inbox(self.program, self.source, Drivers.of(self.program))
        self.offer = Offer(self.publisher, inbox)
        foxglove = Foxglove(self.publisher, inbox, ros2)
        watching = partial(foxglove.serve, watches=True)
        routes = {"/foxglove": foxglove.serve, "/watching": watching}
        app = Starlette(routes=[WebSocketRoute(*item) for item in routes.items()])
        self._listening = listen("127.0.0.1", 0)
        self.url = f"ws://127.0.0.1:{self._listening.getsockname()[1]}/foxglove"
        config = uvicorn.Config(app, ws="websockets-sansio", log_level="warning", lifespan="off")
        self._server = uvicorn.Server(config)
        sockets = {"sockets": [self._listening]}
        self._thread = threading.Thread(target=self._server.run, kwargs=sockets)
        self.shown = []

    def __enter__(self):
        self.source.clock.hold()
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._server.should_exit = True
        self._thread.join(20)
        self.publisher.close()

    def talk(self, wanted, asked=None) -> list[dict]:
        """What a client tells that wants so many messages of each topic."""
        with start_node("foxglove_client.mjs", self.url, wanted, asked) as peer:
            for _ in range(MOST_TICKS):
                self.shown.append(self.program.engine.step())
                if not peer.runs():
                    break
            return peer.told()

    def at(self, header):
        """The tick of a header's stamp."""
        stamp = header["stamp"]["sec"] * 10**9 + stamp_ns(header)
        (found,) = [one for one in self.shown if self.source.clock.ns(one.stamp) == stamp]
        return found


def stamp_ns(header) -> int:
    return header["stamp"].get("nanosec", header["stamp"].get("nsec"))


@pytest.fixture(scope="module")
def rig():
    with Rig(foxglove_commands=True) as rig:
        yield rig


def of(told, name) -> list[dict]:
    return [one["message"] for one in told if one.get("topic") == name]


@needs_node
def test_its_own_client_reads_the_same_values(rig):
    told = rig.talk({"/scan": 1, "/odom": 3, "/map": 1, "/tf_static": 1})
    channels = {one["channel"]: (one["type"], one["encoding"]) for one in told if "channel" in one}
    assert channels == {
        f"/{one.name}": (one.type, "cdr") for one in topics() if one.live and not one.only_dds
    }
    for odom in of(told, "/odom"):
        snapshot = rig.at(odom["header"])
        position = odom["pose"]["pose"]["position"]
        assert (position["x"], position["y"]) == (
            snapshot.odom_from_robot.x,
            snapshot.odom_from_robot.y,
        )
    scan = of(told, "/scan")[0]
    ranges = [float(value) for value in scan["ranges"]]
    seen = [
        one.filter.line_scan.scan.ranges for one in rig.shown if one.filter.line_scan is not None
    ]
    assert any(np.array_equal(np.float32(one), np.float32(ranges)) for one in seen)
    grid = of(told, "/map")[0]
    made = topic("map").make(rig.source, rig.shown[-1])
    assert grid["data"] == made.data.tolist()
    assert grid["info"]["resolution"] == pytest.approx(made.info.resolution)


@needs_node
def test_a_viewer_that_comes_late_is_told_what_is_latched(rig):
    for _ in range(2):
        assert of(rig.talk({"/map": 1, "/robot_description": 1}), "/map")


@needs_node
def test_a_viewer_may_drive_and_is_told_what_was_wrong(rig):
    name = "geometry_msgs/msg/TwistStamped"
    for v, words in ((0.125, None), (50, "less than")):
        twist = {"linear": {**ZERO, "x": v}, "angular": ZERO}
        publish = {
            "topic": "/cmd_vel",
            "schemaName": name,
            "schema": definition(name),
            "message": {"header": {"stamp": NOW, "frame_id": ""}, "twist": twist},
        }
        wanted = {"status": 1} if words else {"/odom": 5}
        told = rig.talk(wanted, {"publish": publish})
        if words:
            assert words in next(one["status"] for one in told if "status" in one)
    taken = [command for one in rig.shown for command in one.commands]
    assert DriveCommand(type="drive", v=0.125, omega=0.0) in taken


@needs_node
def test_services_are_answered(rig):
    scatter = {"name": "/reinitialize_global_localization", "message": {}}
    told = rig.talk({"service": 1}, {"service": scatter})
    assert [one["service"] for one in told if "service" in one] == [True], told
    assert any(isinstance(c, ScatterCommand) for one in rig.shown for c in one.commands)
    header = {"stamp": NOW, "frame_id": "map"}
    at = {"position": {**ZERO, "x": 50}, "orientation": {**ZERO, "w": 1}}
    pose = {"header": header, "pose": {"pose": at, "covariance": [0.0] * 36}}
    wrong = {"name": "/set_initial_pose", "message": {"pose": pose}}
    told = rig.talk({"service": 1}, {"service": wrong})
    (words,) = [one["words"] for one in told if one.get("service") is False]
    assert "off the map" in words


@needs_node
def test_without_the_setting_nobody_may_drive():
    with Rig() as rig:
        told = rig.talk({"/odom": 1})
    (info,) = [one["info"] for one in told if "info" in one]
    assert info["capabilities"] == []


def test_who_only_watches_gives_no_orders(rig):
    address = rig.url.replace("/foxglove", "/watching")
    with connect(address, subprotocols=[SUBPROTOCOLS[0]]) as socket:
        assert json.loads(socket.recv(timeout=20))["capabilities"] == []
        assert json.loads(socket.recv(timeout=20))["op"] == "advertise"
        socket.send(json.dumps({"op": "advertise", "channels": []}))
        assert "only watches" in json.loads(socket.recv(timeout=20))["message"]


def test_an_old_name_of_the_protocol_is_known_too(rig):
    for name in SUBPROTOCOLS:
        with connect(rig.url, subprotocols=["other", name]) as socket:
            assert socket.subprotocol == name
            assert json.loads(socket.recv(timeout=20))["op"] == "serverInfo"


def test_who_speaks_something_else_is_told_so(rig):
    with connect(rig.url, subprotocols=["other"]) as socket:
        with pytest.raises(ConnectionClosed):
            socket.recv(timeout=20)
        assert socket.close_code == 1002
        assert "foxglove.sdk.v1" in socket.close_reason
