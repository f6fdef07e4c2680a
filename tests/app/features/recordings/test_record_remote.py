"""`brickpose record`: a running program, recorded from outside."""

import json
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from http import HTTPStatus
from itertools import pairwise

import cbor2
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from serving import ROOT
from websockets.sync.server import serve

from app.command_line import main
from app.features.recordings.remote_robot import ANSWER_S, RemoteRobot
from app.features.ros.message_types import new, to_cdr

pytestmark = pytest.mark.slow

TEXT = "std_msgs/msg/String"


def record(out, *words) -> int:
    return main(["record", "--out", str(out), *words])


def read(out):
    """Messages of the one recording in a folder, by topic, as rosbags reads them."""
    (folder,) = out.iterdir()
    found: dict[str, list] = {}
    with AnyReader([folder]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found


def attachments(out) -> list[str]:
    (file,) = out.glob("*/*.mcap")
    with file.open("rb") as stream:
        return [one.name for one in make_reader(stream).iter_attachments()]


def test_everything_is_recorded_that_a_replay_needs(server, tmp_path):
    assert record(tmp_path, server.address, "--seconds", "2") == 0
    found = read(tmp_path)
    assert {"/scan", "/odom", "/tf_static", "/map", "/joint_states", "/cmd_vel"} <= set(found)
    assert len(found["/map"]) == len(found["/robot_description"]) == 1
    stamps = [message.header.stamp for _, message in found["/joint_states"]]
    times = [stamp.sec * 10**9 + stamp.nanosec for stamp in stamps]
    assert len(times) > 20
    # Every tick of it: 20 ms in the simulators.
    assert {later - earlier for earlier, later in pairwise(times)} <= {
        20_000_000 + slack for slack in range(-2, 3)
    }
    assert {"settings.toml", "map/stub.svg", "robot/robot.urdf"} <= set(attachments(tmp_path))


def test_only_some_topics(server, tmp_path, capsys):
    assert record(tmp_path, server.address, "--seconds", "1", "--topics", "odom", "/scan") == 0
    assert set(read(tmp_path)) == {"/odom", "/scan"}
    assert "MB are in" in capsys.readouterr().out


def test_a_topic_that_is_not_there_is_answered_with_those_that_are(server, tmp_path, capsys):
    assert record(tmp_path, server.address, "--topics", "lidar") == 2
    assert "/lidar is no topic there; valid are /amcl_pose," in capsys.readouterr().err


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("127.0.0.1:9", "no program can be recorded at 127.0.0.1:9"),
        ("127.0.0.1:0009", "no program can be recorded at 127.0.0.1:9"),
    ],
)
def test_nobody_there(tmp_path, capsys, address, words):
    assert record(tmp_path, address) == 1
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("address", ["", "host:port", "127.0.0.1:99999", "//"])
def test_what_is_no_address_is_a_wrong_argument(tmp_path, capsys, address):
    assert record(tmp_path, address) == 2
    assert f"{address!r} is no address; valid is HOST" in capsys.readouterr().err


def test_a_file_is_no_place_for_recordings(server, tmp_path, capsys):
    file = tmp_path / "notes.txt"
    file.write_text("mine")
    assert record(file, server.address, "--seconds", "1") == 1
    told = capsys.readouterr().err
    assert f"nothing can be recorded to {file}: File exists; valid is a folder" in told
    assert file.read_text() == "mine"


def test_no_time_is_no_recording(tmp_path, capsys):
    assert record(tmp_path, "127.0.0.1:9", "--seconds", "nan") == 2
    assert "valid is more than 0" in capsys.readouterr().err


def test_ctrl_c_ends_it_well(server, tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "app", "record", server.address, "--out", str(tmp_path)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert "Ctrl-C ends it" in process.stdout.readline()
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "MB are in" in out
    assert list(tmp_path.glob("*/*.mcap"))


@contextmanager
def other_robot(*messages, types=(TEXT,), contents=HTTPStatus.NOT_FOUND):
    """A rosbridge of another kind, which says what it is told to and goes."""

    def answer_http(connection, request):
        return connection.respond(contents, "") if request.path.startswith("/api") else None

    def talk(socket):
        for data in socket:
            request = json.loads(data)
            if request["op"] == "call_service":
                names = [f"/topic{number}" for number in range(len(types))]
                values = {"topics": names, "types": list(types)}
                answer = {"op": "service_response", "values": values, "result": True}
                socket.send(json.dumps({**answer, "id": request["id"]}))
            elif request["op"] == "subscribe":
                for message in messages:
                    socket.send(message)
                return

    with serve(talk, "127.0.0.1", 0, process_request=answer_http) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield f"127.0.0.1:{running.socket.getsockname()[1]}"
        running.shutdown()
        thread.join()


def published(text="hello", secs=1_800_000_000):
    cdr = to_cdr(new(TEXT, data=text), TEXT)
    message = {"secs": secs, "nsecs": 5, "bytes": cdr}
    return cbor2.dumps({"op": "publish", "topic": "/topic0", "msg": message})


def test_a_lost_connection_is_told_and_what_came_is_kept(tmp_path, capsys):
    with other_robot(published("one"), published("two")) as address:
        assert record(tmp_path, address) == 1
    error = capsys.readouterr().err
    assert "was lost" in error
    assert "MB are in" in error
    found = read(tmp_path)
    assert [message.data for _, message in found["/topic0"]] == ["one", "two"]
    assert found["/topic0"][0][0] == 1_800_000_000_000_000_005


def test_a_robot_whose_settings_fail_is_not_recorded_without_them(tmp_path, capsys):
    with other_robot(published(), contents=HTTPStatus.SERVICE_UNAVAILABLE) as address:
        assert record(tmp_path, address) == 1
    assert "does not tell its settings: HTTP Error 503" in capsys.readouterr().err
    assert not list(tmp_path.glob("*/*.mcap"))


def test_types_that_nobody_knows_are_left_out(tmp_path, capsys):
    with other_robot(published(), types=(TEXT, "other_msgs/msg/Own")) as address:
        assert record(tmp_path, address) == 1
    assert "/topic1 is not recorded: other_msgs/msg/Own" in capsys.readouterr().out
    assert set(read(tmp_path)) == {"/topic0"}


@pytest.mark.parametrize(
    "junk",
    [
        b"\xff\xff",
        b"",
        "no json",
        cbor2.dumps([1]),
        cbor2.dumps({"op": "publish", "topic": "/topic0", "msg": {"secs": "x"}}),
        published(secs=-1),
        published(secs=2**60),
        json.dumps({"op": "status", "level": "error", "msg": "go away"}),
    ],
)
def test_junk_ends_the_recording_in_words(tmp_path, capsys, junk):
    with other_robot(published("one"), junk) as address:
        assert record(tmp_path, address) == 1
    assert "sent what is no message" in capsys.readouterr().err
    assert len(read(tmp_path)["/topic0"]) == 1


def test_what_the_robot_still_sends_delays_no_end():
    """More than the connection holds: whoever closes it has to wait for room, or give up."""
    with other_robot(*[published()] * 100) as address:
        robot = RemoteRobot(address)
        robot.follow("/topic0", TEXT, 0.0)
        assert robot.receive(10.0)
        start = time.monotonic()
        robot.close()
        assert time.monotonic() - start < ANSWER_S / 2
