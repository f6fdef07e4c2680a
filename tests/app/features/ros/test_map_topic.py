"""The map that is drawn by driving, as ROS sees it: topic, transform, services, files."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from drawn_maps import LAP_S, MappingBench
from engine_runs import EIGHT, run
from ros_messages import topic
from rosbridge_sessions import ByHand, Client

from app.engine.drivers import Driver
from app.engine.snapshot import Snapshot
from app.features.mapping.drawing_work import STEP_S
from app.features.mapping.messages import DeleteStrokeCommand
from app.features.ros.foxglove.offer import Offer
from app.features.ros.foxglove.session import FoxgloveSession
from app.features.ros.outlet import INBOX, PUBLISHER
from app.features.ros.publisher import Pace
from app.features.ros.rosbridge.bridge import Bridge
from app.features.ros.topics import UNCHANGING, Published
from app.settings.groups import MappingSettings
from robot.fields.grid_map import load_map_yaml
from robot.geometry import Pose2

pytestmark = pytest.mark.slow

ME = Driver("me")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def bench(folder) -> Iterator[MappingBench]:
    made = MappingBench(mapping=MappingSettings(folder=str(folder)))
    made.outlets.part(PUBLISHER).source.clock.hold()
    yield made
    made.close()


@pytest.fixture(scope="module")
def client(bench) -> Client:
    outlets = bench.outlets
    publisher = ByHand(outlets.part(PUBLISHER).source, bench.program.engine.every)
    return Client(Bridge(publisher, outlets.part(INBOX)))


@pytest.fixture(scope="module")
def lap(bench, client) -> list[Snapshot]:
    """A lap, drawn from a service's call on; and the map that was saved half-way."""
    assert client.call("/slam_toolbox/save_map", {"name": {"data": "early"}}) == (
        True,
        {"result": 1},
    )
    assert client.call("slam_toolbox/reset", {}) == (True, {"result": 0})
    shown = []
    for _ in range(round(LAP_S)):
        shown += run(bench.program, 1.0, EIGHT)
        if len(shown) > 100:
            bench.catch_up(shown[-1])
    return shown


def told(bench, snapshot: Snapshot, name: str):
    one = topic(name)
    return Published(
        one, one.stamp(snapshot), bench.outlets.part(PUBLISHER).source, snapshot
    ).message


def cells(message) -> np.ndarray:
    return message.data.reshape(message.info.height, message.info.width)


def at(message, x: float, y: float) -> int:
    """The cell at a place of the map [m]."""
    origin, side = message.info.origin.position, message.info.resolution
    return int(cells(message)[int((y - origin.y) / side), int((x - origin.x) / side)])


def test_the_map_grows_on_its_topic(bench, lap):
    stamps = [topic("map").stamp(snapshot) for snapshot in lap]
    drawn = sorted(set(stamps) - {UNCHANGING})
    assert stamps[0] == UNCHANGING
    assert len(drawn) > 5
    # Not more often than there is enough new, and each time there is more.
    assert len(drawn) <= LAP_S / STEP_S + 1
    seen = [
        int((cells(told(bench, snapshot, "map")) == 0).sum())
        for number, snapshot in enumerate(lap)
        if number and stamps[number] != stamps[number - 1]
    ]
    assert seen[-1] > 1.5 * seen[0]


def test_its_cells_are_tape_seen_floor_and_unknown(bench, lap):
    message = told(bench, lap[-1], "map")
    assert message.info.resolution == bench.program.config.ros2.map_resolution
    assert set(np.unique(message.data)) == {-1, 0, 100}
    assert message.header.frame_id == "map"
    assert at(message, 0.5, 0.3) == 100
    assert at(message, 0.3, 0.3) == 0
    # What is behind the tape is not looked at.
    assert at(message, 0.5 + 0.06, 0.5 + 0.06) == -1
    known = told(bench, lap[0], "map")
    tape = [(cells(grid) == 100).sum() * grid.info.resolution**2 for grid in (message, known)]
    # Strokes that grow end before the corners.
    assert 0.85 * tape[1] < tape[0] < 1.02 * tape[1]


def test_a_route_gets_each_of_them_and_the_fields_again_at_the_end(lap):
    one, pace = topic("map"), Pace(lambda topic: 0.0)
    stamps = [one.stamp(snapshot) for snapshot in (*lap, lap[0])]
    due = [stamp for stamp in stamps if pace.due(one, stamp)]
    assert due == [UNCHANGING, *sorted(set(stamps) - {UNCHANGING}), UNCHANGING]


def test_the_transform_leads_into_the_map_that_is_drawn(bench, lap):
    last = lap[-1]
    transforms = {one.child_frame_id: one.transform for one in told(bench, last, "tf").transforms}
    found = transforms["odom"]
    turn = 2 * np.arctan2(found.rotation.z, found.rotation.w)
    map_from_odom = Pose2(found.translation.x, found.translation.y, turn)
    assert map_from_odom.distance_to(last.drawn.map_from_odom) < 1e-9
    robot = map_from_odom @ last.odom_from_robot
    assert robot.distance_to(last.truth) < 0.005


def test_pause_takes_turns_as_in_slam_toolbox(bench, client, lap):
    for paused in (True, False):
        assert client.call("/slam_toolbox/pause_new_measurements") == (True, {"status": True})
        assert bench.drawer.drawing.paused is paused


def test_a_finished_map_is_saved_and_read_by_the_rules_of_map_server(bench, client, lap, folder):
    bench.drive(0.5)
    bench.finish()
    shown = run(bench.program, 0.1)[-1]
    assert topic("map").stamp(shown) > topic("map").stamp(lap[-1])
    call = {"name": {"data": "kitchen"}}
    assert client.call("/slam_toolbox/save_map", call) == (True, {"result": 0})
    assert {path.name for path in folder.iterdir()} >= {
        "kitchen.svg",
        "kitchen.yaml",
        "kitchen.pgm",
    }
    # A name that is taken, and a path.
    assert client.call("/slam_toolbox/save_map", call) == (True, {"result": 255})
    path = {"name": {"data": str(folder / "hall")}}
    assert client.call("/slam_toolbox/save_map", path) == (True, {"result": 255})
    content = yaml.safe_load((folder / "kitchen.yaml").read_text())
    assert set(content) == {
        "image",
        "mode",
        "resolution",
        "origin",
        "negate",
        "occupied_thresh",
        "free_thresh",
    }
    grid = as_map_server_reads(content, folder)
    assert (grid == load_map_yaml(folder / "kitchen.yaml").data).all()
    assert set(np.unique(grid)) == {-1, 0, 100}
    x, y, yaw = content["origin"]
    assert yaw == 0
    places = {(0.5, 0.3): 100, (0.3, 0.3): 0, (0.7, 0.7): -1}
    side = content["resolution"]
    for (px, py), value in places.items():
        assert grid[int((py - y) / side), int((px - x) / side)] == value


def as_map_server_reads(content: dict, folder: Path) -> np.ndarray:
    """The cells that nav2_map_server makes of a map, by its documentation, bottom row first.

    Darkness above ``occupied_thresh`` is occupied, below ``free_thresh`` free, and else unknown.
    """
    assert content["mode"] == "trinary"
    assert content["negate"] == 0
    assert 0 < content["free_thresh"] < content["occupied_thresh"] < 1
    assert (folder / content["image"]).read_bytes().startswith(b"P5")
    grey = cv2.imread(str(folder / content["image"]), cv2.IMREAD_UNCHANGED)
    dark = (255 - grey.astype(float)) / 255
    cells = np.full(dark.shape, -1)
    cells[dark > content["occupied_thresh"]] = 100
    cells[dark < content["free_thresh"]] = 0
    return cells[::-1]


def test_foxglove_calls_the_same_services(bench, client, folder):
    outlets = bench.outlets
    publisher = ByHand(outlets.part(PUBLISHER).source, bench.program.engine.every)
    offer = Offer(publisher, outlets.part(INBOX))
    session = FoxgloveSession(offer, lambda: None, ME, None)
    services = [service.name for service in outlets.part(INBOX).services()]

    def call(name: str, content: bytes, encoding: bytes = b"json"):
        head = struct.pack("<BIII", 2, services.index(name), 7, len(encoding))
        (answer,) = session.receive(head + encoding + content)
        data = answer() if callable(answer) else answer
        return data[13 + len(encoding) :]

    saved = call("slam_toolbox/save_map", json.dumps({"name": {"data": "hall"}}).encode())
    assert json.loads(saved) == {"result": 0}
    assert (folder / "hall.pgm").exists()
    # CDR: its header, then the byte.
    request = b"\0\1\0\0" + struct.pack("<I", 5) + b"hall\0"
    assert call("slam_toolbox/save_map", request, b"cdr") == b"\0\1\0\0\xff"
    assert json.loads(call("slam_toolbox/pause_new_measurements", b"{}")) == {"status": False}


def test_a_stroke_that_is_deleted_is_not_in_the_cells(bench):
    drawing, before = bench.drawer.drawing, run(bench.program, 0.02)[-1]
    command = DeleteStrokeCommand(type="delete_stroke", stroke=0, version=drawing.version)
    bench.outlets.carry_out(ME, command)
    after = run(bench.program, 0.02)[-1]
    tape = [(snapshot.drawn.grid.data == 100).sum() for snapshot in (before, after)]
    assert tape[1] < 0.9 * tape[0]


def test_discarded_it_is_the_fields_again(bench, client, lap):
    bench.drawer.discard()
    shown = run(bench.program, 0.1)[-1]
    assert topic("map").stamp(shown) == UNCHANGING
    before = told(bench, lap[0], "map")
    assert (told(bench, shown, "map").data == before.data).all()
    assert client.call("/slam_toolbox/save_map", {"name": {"data": "late"}}) == (
        True,
        {"result": 1},
    )
    assert client.call("/slam_toolbox/reset", {"pause_new_measurements": True})[1] == {"result": 0}
    assert bench.drawer.drawing.paused
    bench.drawer.discard()
