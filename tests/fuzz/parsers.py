"""Each of the program's readers of foreign bytes, as one kind of function.

A parser takes bytes, and a folder that it may write to. It returns the words of the refusal, or
None if the bytes are valid. Any exception that it lets through is a defect.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from engine_runs import kinematic, run
from rosbridge_sessions import Client, bridge_of

from app.engine.commands import check, parse
from app.engine.drivers import Driver, Drivers
from app.engine.program import Program
from app.features.kept_pose.pose_file import PoseFileError
from app.features.kept_pose.pose_file import read as read_pose
from app.features.lab.sweep.sweep_file import load_sweep
from app.features.lab.trajectories.reading import read_trajectory
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.remote_robot import parse_received
from app.features.recordings.replay.opening import read_filter_config
from app.features.recordings.replay.parts import RecordedParts
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.features.recordings.replay.ticks import RecordedTopics
from app.features.ros.foxglove.offer import Offer
from app.features.ros.foxglove.session import FoxgloveSession
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import MessageError
from app.features.ros.rosbridge.bridge import Bridge
from app.messages.commands import ErrorMessage
from app.settings.config import MAPS, load_config
from app.trajectories.trajectory import TrajectoryError
from robot.camera import CameraError
from robot.description.profile import load_profile
from robot.description.spec import SPIKE, RobotSpec, SpecError
from robot.driving.differential_drive import DifferentialDrive
from robot.errors import BrickPoseError, CommandError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.hat.protocol.decoder import Decoder
from robot.hat.protocol.events import Event, UnknownLine
from robot.lens_files.reading import read_lens_file
from robot.settings import SettingError

Parser = Callable[[bytes, Path], str | None]

LENS = SPIKE.parent / "pi_camera.yaml"
ME = Driver.numbered("fuzz")
CONTENT = b"\n\n"
"""Between a first line, which says how the rest is encoded, and the rest."""


def of_file(name: str, read: Callable[[Path], object], *refusals: type[BrickPoseError]) -> Parser:
    """A parser of files of that name; ``refusals`` are the errors that the reader documents."""

    def parser(data: bytes, folder: Path) -> str | None:
        path = folder / name
        path.write_bytes(data)
        try:
            read(path)
        except refusals as error:
            return str(error)
        return None

    return parser


def hat(data: bytes, folder: Path) -> str | None:
    """What the Build HAT says, in one piece and in three: the events are the same."""
    events = Decoder().feed(data)
    third, decoder = len(data) // 3, Decoder()
    pieces = data[:third], data[third : 2 * third], data[2 * third :]
    apart = [event for piece in pieces for event in decoder.feed(piece)]
    assert repr(apart) == repr(events)  # NaN differs from itself
    assert all(isinstance(event, Event) for event in events)
    unknown = sum(isinstance(event, UnknownLine) for event in events)
    return f"{unknown} lines are not understood" if unknown else None


@cache
def program() -> Program:
    """A robot that has seen its first pictures."""
    made = kinematic()
    run(made, 0.2)
    return made


@cache
def bridge() -> Bridge:
    """rosbridge around it."""
    return bridge_of(program())


def _forget_commands() -> None:
    while program().engine.commands.take():
        pass


def live(data: bytes, folder: Path) -> str | None:
    """A command of the page; its refusal can be sent."""
    try:
        command = parse(data.decode(errors="replace"))
        check(command, program())
        Drivers.of(program()).put(ME, command)
    except BrickPoseError as error:
        assert isinstance(error, CommandError)
        ErrorMessage(id=None, message=str(error)).model_dump_json()
        return str(error)
    finally:
        _forget_commands()
    return None


def rosbridge(data: bytes, folder: Path) -> str | None:
    """Messages of one client, a line each; the first refusal."""
    client = Client(bridge())
    client.send('{"op": "set_level", "level": "error"}')
    try:
        answers = [answer for line in data.split(b"\n") for answer in client.send(_text(line))]
    finally:
        client.session.close()
        _forget_commands()
    words = [answer.get("msg") or answer.get("values") for answer in answers if _refuses(answer)]
    return str(words[0]) if words else None


def _text(line: bytes) -> str | bytes:
    try:
        return line.decode()
    except UnicodeDecodeError:
        return line


def _refuses(answer: dict[str, object]) -> bool:
    assert answer["op"] in ("status", "service_response"), answer
    return answer["op"] == "status" or answer["result"] is False


def _inbox() -> Inbox:
    """An inbox of a robot that nobody drives yet."""
    return Inbox(program(), bridge().inbox.source, Drivers.of(program()))


def foxglove(data: bytes, folder: Path) -> str | None:
    """A viewer's channel (topic, type and encoding in the first line) and its message."""
    head, _, content = data.partition(CONTENT)
    topic, kind, encoding, *_ = [*head.decode(errors="replace").split(), "", "", ""]
    channel = {"id": 1, "topic": topic, "schemaName": kind, "encoding": encoding}
    inbox = _inbox()
    offer = Offer(bridge().publisher, inbox)
    session = FoxgloveSession(offer, lambda: None, ME, refusal=None)
    sent: list[str | bytes] = [
        json.dumps({"op": "advertise", "channels": [channel]}),
        b"\x01\x01\0\0\0" + content,
    ]
    # As words, and as bytes of any kind, the content may be anything.
    rest = [content.decode(errors="replace"), content]
    try:
        answers = [answer for message in sent for answer in session.receive(message)]
        for message in rest:
            session.receive(message)
    finally:
        session.close()
        _forget_commands()
    return str(json.loads(answers[0])["message"]) if answers else None


def dds(data: bytes, folder: Path) -> str | None:
    """A message in CDR (topic and type in the first line)."""
    head, _, content = data.partition(CONTENT)
    topic, kind, *_ = [*head.decode(errors="replace").split(), "", ""]
    try:
        _inbox().take(topic, kind, content, ME)
    except (MessageError, CommandError) as error:
        return str(error)
    finally:
        _forget_commands()
    return None


def remote(data: bytes, folder: Path) -> str | None:
    """What another robot's rosbridge sends to a recorder: JSON is text, all else is CBOR."""
    try:
        parse_received(data.decode() if data.startswith(b"{") else data)
    except MessageError as error:
        return str(error)
    except UnicodeDecodeError:
        return "no text"  # the socket refuses it
    return None


def read_recording(path: Path) -> None:
    """Read all messages and attachments."""
    reader = open_recording(path)
    for _ in reader.messages():
        pass
    for name in reader.attachments:
        reader.attachments[name]


def replay_recording(path: Path) -> None:
    """Read the parts that a replay needs, and its first ticks."""
    reader = open_recording(path)
    topics = RecordedTopics.of(reader.topics)
    parts = RecordedParts.of(reader)
    drive = DifferentialDrive(parts.spec, parts.config.drive.multipliers)
    robot = RecordedRobot(reader, topics, parts.spec, drive, "Recording")
    while robot.next_ns is not None:
        robot.commands()
        for fault in robot.read().faults:
            assert len(fault.splitlines()) == 1, fault
        robot.write(robot.write([]))
    robot.close()


def map_yaml(data: bytes, folder: Path) -> str | None:
    """The YAML of a ROS map, beside a good picture."""
    (folder / "map.pgm").write_bytes(b"P5 4 3 255\n" + bytes([254, 254, 254, 254, 0, 254] * 2))
    return _map(data, folder)


def map_picture(data: bytes, folder: Path) -> str | None:
    """The picture of a ROS map: PGM, PPM, PNG or BMP."""
    (folder / "map.pgm").write_bytes(data)
    keys = {"image": "map.pgm", "resolution": 0.05, "origin": [0, 0, 0], "negate": 0}
    return _map(json.dumps(keys | {"occupied_thresh": 0.65, "free_thresh": 0.196}).encode(), folder)


_map = of_file("map.yaml", lambda path: load_field(str(path), MAPS), FieldError)


def svg(path: Path) -> None:
    """Load a drawing, and what is computed of it at the start."""
    field = load_field(str(path), MAPS)
    assert np.isfinite(field.edges).all()
    _ = field.edge_index, field.symmetries


def urdf(data: bytes, folder: Path) -> str | None:
    """A robot's description, beside its lens."""
    if not (folder / LENS.name).exists():
        shutil.copy(LENS, folder)
    return of_file("robot.urdf", robot_view, SpecError)(data, folder)


def robot_view(path: Path) -> None:
    """Load a robot; its dimensions make sense."""
    spec = RobotSpec.load(path)
    assert min(spec.wheel_radius, spec.track) > 0
    assert np.isfinite(spec.robot_from_camera).all()
    assert np.isfinite(spec.outline).all()


def lens_view(path: Path) -> None:
    """Load a lens; its numbers are finite."""
    lens = read_lens_file(path).lens
    assert lens.width * lens.height > 0
    assert np.isfinite(lens.matrix).all()
    assert np.isfinite(lens.distortion).all()
    assert 0 <= lens.readout < 1


def profile_view(path: Path) -> None:
    """Load a robot's profile; the robot that it makes has finite numbers."""
    spec = load_profile(path).applied_to(RobotSpec.load())
    assert min(spec.wheel_radius, spec.track) > 0
    assert np.isfinite(spec.robot_from_camera).all()
    assert np.isfinite(spec.lens.matrix).all()
    assert np.isfinite(spec.picture_delay)


def replay_settings(path: Path) -> None:
    """Settings of a replay."""
    read_filter_config(path)


SETTINGS = of_file("config.toml", load_config, SettingError)
REPLAY_SETTINGS = of_file("filter.toml", replay_settings, SettingError)
PROFILE = of_file("profile.toml", profile_view, SpecError, SettingError)
SWEEP = of_file("sweep.toml", load_sweep, SettingError)
TRAJECTORY = of_file("path.txt", read_trajectory, TrajectoryError)
DRAWING = of_file("drawing.svg", svg, FieldError)
LENS_FILE = of_file("lens.yaml", lens_view, CameraError)
POSE = of_file("pose.json", lambda path: read_pose(path, program().field), PoseFileError)
RECORDING = of_file("recording.mcap", read_recording, RecordingError)
REPLAY = of_file(
    "replay.mcap", replay_recording, RecordingError, SettingError, FieldError, SpecError
)
