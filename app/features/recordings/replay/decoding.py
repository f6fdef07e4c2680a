"""Decodes recorded messages; a recording may hold anything."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterator, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from app.engine.commands import adapter, refusal_of
from app.features.ros.encoding.frames import SECOND_NS, heading_of
from app.features.ros.message_types import from_cdr
from app.messages.commands import Command, SetPoseCommand
from robot.covariance import by_rows
from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, Twist2

PNG = b"\x89PNG\r\n\x1a\n"
JPEG = b"\xff\xd8"

FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of JPEG that are followed by the size."""

ALONE = frozenset({0x01, *range(0xD0, 0xD9)})
"""Markers of JPEG without a length."""


def size_of(data: bytes) -> tuple[int, int] | None:
    """Height and width [pixels] that a JPEG or a PNG states; None if it is neither."""
    try:
        if data.startswith(PNG):
            width, height = struct.unpack_from(">II", data, 16)
            return height, width
        return _jpeg(data) if data.startswith(JPEG) else None
    except (struct.error, IndexError):
        return None


def _jpeg(data: bytes) -> tuple[int, int] | None:
    """Read the size from the first marker of a frame (ITU T.81, annex B)."""
    offset = len(JPEG)
    while data[offset] == 0xFF:
        marker = data[offset + 1]
        if marker in FRAMES:
            height, width = struct.unpack_from(">HH", data, offset + 5)
            return height, width
        if marker == 0xFF:
            offset += 1  # fill byte
        elif marker in ALONE:
            offset += 2
        else:
            offset += 2 + struct.unpack_from(">H", data, offset + 2)[0]
    return None


class ContentError(BrickPoseError, ValueError):
    """A message has no usable content; says why."""


def stamp_ns(message: Any) -> int:
    """The stamp of a message's header."""
    stamp = message.header.stamp
    return int(stamp.sec) * SECOND_NS + int(stamp.nanosec)


def joints_of(cdr: bytes, names: Sequence[str]) -> tuple[int, Array, Array | None]:
    """Stamp [ns], positions and velocities (j,) of the named joints; velocities may be missing.

    Raises:
        MessageError, ContentError: a joint is missing, or its position is not a number.
    """
    message = from_cdr(cdr, "sensor_msgs/msg/JointState")
    has = list(message.name)
    missing = [name for name in names if name not in has]
    if missing:
        raise ContentError(
            f"joint_states has the joints {', '.join(has) or 'none'}; "
            f"this robot's are {', '.join(names)}"
        )
    places = [has.index(name) for name in names]
    positions = _numbers(message.position, places)
    if positions is None:
        raise ContentError("joint_states has positions that are missing or no numbers")
    return stamp_ns(message), positions, _numbers(message.velocity, places)


def _numbers(values: Any, places: list[int]) -> Array | None:
    result = np.asarray(values, dtype=np.float64)
    if len(result) <= max(places) or not np.isfinite(result[places]).all():
        return None
    return result[places]


def picture_of(cdr: bytes, size: tuple[int, int]) -> tuple[int, NDArray[np.uint8]]:
    """Stamp [ns] and picture of a CompressedImage, grey or BGR.

    Raises:
        MessageError, ContentError: the picture is damaged, or its size (height, width) differs.
    """
    message = from_cdr(cdr, "sensor_msgs/msg/CompressedImage")
    data = np.asarray(message.data, dtype=np.uint8)
    unreadable = f"a picture of format {message.format!r} cannot be read; valid is JPEG"
    # A few bytes may become gigabytes of pixels: the size is checked before they are decoded.
    _check_size(size_of(data.tobytes()), size, unreadable)
    try:
        image = cv2.imdecode(data, cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    except cv2.error as error:
        raise ContentError(f"a picture cannot be read: {error.err}") from error
    if image is None:
        raise ContentError(unreadable)
    _check_size(image.shape[:2], size, unreadable)
    return stamp_ns(message), np.asarray(image, dtype=np.uint8)


def _check_size(result: Sequence[int] | None, size: tuple[int, int], unreadable: str) -> None:
    if result is None:
        raise ContentError(unreadable)
    if tuple(result) != size:
        raise ContentError(
            f"a picture has {result[1]} x {result[0]} pixels; this robot's camera has "
            f"{size[1]} x {size[0]}"
        )


def pose_of(pose: Any) -> Pose2:
    """A geometry_msgs/Pose on the floor.

    Raises:
        ContentError: it has numbers that are not finite.
    """
    position, turn = pose.position, pose.orientation
    pose2 = Pose2(float(position.x), float(position.y), heading_of(turn))
    if not pose2.is_finite():
        raise ContentError("a pose has numbers that are not finite")
    return pose2


def pose_and_covariance_of(cdr: bytes) -> tuple[int, Pose2, Array]:
    """Stamp [ns], pose and covariance (3, 3) [m², m rad, rad²] of a PoseWithCovarianceStamped.

    Raises:
        MessageError, ContentError: it has numbers that are not finite.
    """
    message = from_cdr(cdr, "geometry_msgs/msg/PoseWithCovarianceStamped")
    whole = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)
    flat = whole[np.ix_([0, 1, 5], [0, 1, 5])]
    if not np.isfinite(flat).all():
        raise ContentError("a covariance has numbers that are not finite")
    return stamp_ns(message), pose_of(message.pose.pose), flat / 2 + flat.T / 2


def truth_of(cdr: bytes) -> tuple[int, Pose2]:
    """Stamp [ns] and pose of a PoseStamped.

    Raises:
        MessageError, ContentError: it has numbers that are not finite.
    """
    message = from_cdr(cdr, "geometry_msgs/msg/PoseStamped")
    return stamp_ns(message), pose_of(message.pose)


def twist_of(cdr: bytes) -> Twist2 | None:
    """The velocity of a TwistStamped; None if it is not finite."""
    twist = from_cdr(cdr, "geometry_msgs/msg/TwistStamped").twist
    twist2 = Twist2(float(twist.linear.x), float(twist.angular.z))
    return twist2 if math.isfinite(twist2.v) and math.isfinite(twist2.omega) else None


def volts_of(cdr: bytes) -> float | None:
    """The voltage of a BatteryState; None if it is not known."""
    volts = float(from_cdr(cdr, "sensor_msgs/msg/BatteryState").voltage)
    return volts if math.isfinite(volts) else None


def health_of(cdr: bytes) -> tuple[bool, tuple[str, ...]] | None:
    """Whether the robot was connected, and its faults; None if the message is not BrickPose's."""
    message = from_cdr(cdr, "diagnostic_msgs/msg/DiagnosticArray")
    status = {item.name: item for item in message.status}
    program, robot = status.get("brickpose: program"), status.get("brickpose: robot")
    if program is None or robot is None:
        return None
    figures = {value.key: value.value for value in program.values}
    # The level is a byte, which some readers return as bytes and not as a number.
    bad = robot.level not in (0, b"\0")
    return figures.get("connected") != "false", (str(robot.message),) if bad else ()


def commands_of(cdr: bytes) -> tuple[Command, ...]:
    """The commands in a String, which holds a JSON list of them, or only one.

    Those that cannot be read are left out; ``require_commands`` names them.

    Raises:
        MessageError, ContentError: it holds no commands.
    """
    return tuple(command for command in _read_commands(cdr) if not isinstance(command, str))


def require_commands(cdr: bytes) -> None:
    """Refuse commands that cannot be read.

    Raises:
        MessageError, ContentError: names the first.
    """
    for command in _read_commands(cdr):
        if isinstance(command, str):
            raise ContentError(f"a recorded command cannot be read: {command}")


def _read_commands(cdr: bytes) -> Iterator[Command | str]:
    """Yield each command, or why it cannot be read."""
    text = from_cdr(cdr, "std_msgs/msg/String").data
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ContentError(f"a recorded command cannot be read: {str(error)[:200]}") from error
    for item in content if isinstance(content, list) else [content]:
        try:
            yield adapter().validate_json(json.dumps(item))
        except ValidationError as error:
            yield refusal_of(error)
        except (ValueError, RecursionError) as error:
            yield str(error)[:200]


def set_pose_of(cdr: bytes) -> Command:
    """The command for the filter in an initialpose.

    Raises:
        MessageError, ContentError: it has numbers that are not finite.
    """
    _, pose, covariance = pose_and_covariance_of(cdr)
    return SetPoseCommand(
        type="set_pose",
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        covariance=by_rows(covariance) if covariance.any() else None,
    )
