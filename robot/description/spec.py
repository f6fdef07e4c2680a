"""The robot's spec, read from its description: the source of every dimension in the program."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from shapely import MultiPoint, Polygon
from shapely.geometry.polygon import orient

from robot.camera import CameraError, FloorView, Lens
from robot.description.lens_file import read_lens
from robot.description.rigid_bodies import with_inertia
from robot.description.robot_model import RobotModel, place_link, read_model
from robot.description.urdf import SpecError, origin_of, parse_xml, shape_of, text_of
from robot.description.wheels import ROBOT_FRAME, JointSpec, read_wheels, resize_wheel
from robot.geometry import Array

__all__ = ["SPIKE", "JointSpec", "RobotSpec", "SpecError"]

SPIKE = Path(__file__).parent / "spike.urdf"


@dataclass(frozen=True, eq=False)
class RobotSpec:
    """A differential-drive robot with one camera, read from a URDF and a lens file."""

    name: str
    joints: tuple[JointSpec, ...]
    """The driven joints; all joint arrays have this order."""
    lens: Lens
    robot_from_camera: Array = field(repr=False)
    """Transform (4, 4) from the camera's optical frame to the robot frame on the floor."""
    outline: Array = field(repr=False)
    """Convex outline (k, 2) [m] of the robot seen from above, anticlockwise, not closed."""
    urdf: str = field(repr=False)
    """The description as text, with inertia filled in."""
    picture_delay: float = 0.0
    """How much later than its exposure a picture is stamped [s]."""
    measured: str = ""
    """When and from what a calibration measured the robot; empty if none did."""
    profile: str = field(default="", repr=False)
    """The profile that corrected it, as the text of its file; empty if none did."""
    drawing: RobotSpec | None = field(default=None, repr=False)
    """The description before a calibration corrected it; None if none did."""
    measured_sd: Array | None = field(default=None, repr=False)
    """(11,) standard deviations of what was measured, as in the profile; None if nothing was."""
    base: RobotSpec | None = field(default=None, repr=False)
    """The description from which the calibration's differences count: the drawing, with its lens
    as measured; None if none did."""

    @staticmethod
    def load(path: Path = SPIKE) -> RobotSpec:
        """Read a URDF and the lens file that it names, in the same folder.

        Raises:
            SpecError: a file cannot be read or used; the message names the file, what is wrong and
                what is valid.
        """
        return _spike() if path == SPIKE else _read(path)

    @classmethod
    def from_urdf(cls, text: str, folder: Path) -> RobotSpec:
        """Read the text of a URDF; the lens file that it names is in the folder.

        Raises:
            SpecError, CameraError: as ``load``, without the file's name.
        """
        urdf = with_inertia(text)
        root, model = parse_xml(urdf), read_model(urdf)
        if model.root != ROBOT_FRAME:
            raise SpecError(f"the root link is {model.root!r}; it must be {ROBOT_FRAME!r}")
        joints, sensor = read_wheels(root, model), _camera_sensor(root)
        return cls(
            name=root.get("name", "robot"),
            joints=joints,
            lens=read_lens(folder / _lens_name(sensor)),
            robot_from_camera=_camera_pose(model, text_of(sensor, "frame", "the camera")),
            outline=_outline(root, model),
            urdf=urdf,
        )

    def with_wheels(self, radii: Sequence[float], track: float) -> RobotSpec:
        """Return the same robot with other wheels.

        The wheels' centres move up or down with the radii, so that the robot stands level: a tilt
        would be an error of the camera's mounting, not of the wheels.

        Args:
            radii: (j,) [m] in the order of the joints.
            track: distance between the middles of the wheels [m].

        Raises:
            SpecError: a dimension is not a number above zero, or the number of radii is wrong.
        """
        if len(radii) != len(self.joints):
            raise SpecError(f"{len(radii)} radii for {len(self.joints)} wheels")
        for value in (*radii, track):
            if not (math.isfinite(value) and value > 0):
                raise SpecError(f"a wheel's dimension is {value:g} m; it must be above zero")
        root, model = parse_xml(self.urdf), read_model(self.urdf)
        joints = tuple(
            replace(joint, radius=float(r), offset=math.copysign(track / 2, joint.offset))
            for joint, r in zip(self.joints, radii, strict=True)
        )
        for joint in joints:
            resize_wheel(root, model, joint)
        urdf = with_inertia(ElementTree.tostring(root, encoding="unicode"))
        outline = _outline(parse_xml(urdf), read_model(urdf))
        return replace(self, joints=joints, outline=outline, urdf=urdf)

    def with_camera(self, lens: Lens, robot_from_camera: Array) -> RobotSpec:
        """Return the same robot with another lens, or the camera mounted otherwise.

        The URDF has the camera where it is; the lens is beside it, in the file that it names.

        Args:
            robot_from_camera: (4, 4) from the camera's optical frame to the robot frame.
        """
        root, model = parse_xml(self.urdf), read_model(self.urdf)
        frame = text_of(_camera_sensor(root), "frame", "the camera")
        place_link(root, model, frame, robot_from_camera)
        urdf = ElementTree.tostring(root, encoding="unicode")
        outline = _outline(root, read_model(urdf))
        return replace(
            self, lens=lens, robot_from_camera=robot_from_camera, outline=outline, urdf=urdf
        )

    @property
    def as_drawn(self) -> RobotSpec:
        """The robot as its URDF has it, without a calibration."""
        return self.drawing or self

    @property
    def uncalibrated(self) -> RobotSpec:
        """The robot as drawn, with its lens as measured: what differences count from."""
        return self.base or self

    @property
    def axle(self) -> tuple[int, int]:
        """Indices of the left and the right wheel among the joints."""
        return (0, 1) if self.joints[0].offset > self.joints[1].offset else (1, 0)

    @property
    def wheel_radius(self) -> float:
        """Mean radius of the wheels [m]."""
        return sum(joint.radius for joint in self.joints) / len(self.joints)

    @property
    def track(self) -> float:
        """Distance between the middles of the wheels [m]."""
        left, right = self.axle
        return self.joints[left].offset - self.joints[right].offset

    @property
    def max_v(self) -> float:
        """Highest speed straight ahead [m/s]."""
        return min(joint.radius * joint.max_velocity for joint in self.joints)

    @property
    def max_omega(self) -> float:
        """Highest turning speed on the spot [rad/s]."""
        return 2 * self.max_v / self.track

    @cached_property
    def floor_view(self) -> FloorView:
        """The camera above the floor: which floor point each pixel sees."""
        return FloorView(self.lens, self.robot_from_camera)


@cache
def _spike() -> RobotSpec:
    """Read the program's own robot, once."""
    return _read(SPIKE)


def _read(path: Path) -> RobotSpec:
    try:
        return RobotSpec.from_urdf(path.read_text(encoding="utf-8"), path.parent)
    except (OSError, UnicodeDecodeError) as error:
        raise SpecError(f"{path}: no readable robot description: {error}") from error
    except (SpecError, CameraError) as error:
        raise SpecError(f"{path}: {error}") from error


def _camera_sensor(root: ElementTree.Element) -> ElementTree.Element:
    for sensor in root.findall("ros2_control/sensor"):
        if sensor.find("param[@name='camera_info']") is not None:
            return sensor
    raise SpecError(
        "no camera: <ros2_control> needs a <sensor> with <param>s frame (the link of the optical "
        "frame) and camera_info (the lens file)"
    )


def _lens_name(sensor: ElementTree.Element) -> str:
    """Return the name of the lens file: no path, as a recording's URDF comes from anybody."""
    name = text_of(sensor, "camera_info", "the camera")
    if Path(name).name != name:
        raise SpecError(f"camera_info is {name!r}; valid is a file beside the description")
    return name


def _camera_pose(model: RobotModel, frame: str) -> Array:
    """Return the transform (4, 4) from the optical frame to the robot frame."""
    if frame not in model.names:
        raise SpecError(f"the camera's frame {frame!r} is no link; there should be such a one")
    robot_from_camera: Array = model.transform(frame, ROBOT_FRAME)
    if robot_from_camera[2, 3] <= 0:
        raise SpecError(f"the camera is {robot_from_camera[2, 3]:g} m high; it must be above 0")
    if robot_from_camera[2, 2] >= 0:
        raise SpecError(
            f"the camera frame {frame!r} looks up or level; its z axis must point down to the floor"
        )
    return robot_from_camera


def _outline(root: ElementTree.Element, model: RobotModel) -> Array:
    corners = []
    for link in root.findall("link"):
        name = str(link.get("name"))
        robot_from_link = model.transform(name, ROBOT_FRAME)
        for visual in link.findall("visual"):
            where = f"link {name!r}"
            points = shape_of(visual, where).corners()
            robot_from_shape = robot_from_link @ origin_of(visual, where)
            corners.append(points @ robot_from_shape[:2, :3].T + robot_from_shape[:2, 3])
    hull = MultiPoint(np.vstack(corners)).convex_hull
    assert isinstance(hull, Polygon)  # two wheels apart span an area
    return np.array(orient(hull).exterior.coords)[:-1]
