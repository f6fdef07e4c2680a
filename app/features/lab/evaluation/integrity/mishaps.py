"""Conditions that are no setting: what befalls a robot while it drives, and floors not as drawn."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages.driving_commands import DriveCommand
from app.settings.conditions import CONDITIONS, apply_condition
from app.settings.config import Config, with_settings
from robot.fields.edges import lengths
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Frame, Reading, RepositionableRobot, Robot
from robot.settings import SettingError

MISHAP = 9
"""Number of the random stream, beside the seed, that a mishap is drawn from."""
BEGINS = (3.0, 5.0)
"""When something happens on a drive along a line [s]."""
STUCK = 2.0
"""How long a robot is stuck while its wheels turn [s]."""
PUSH = (0.10, 0.25)
"""Shortest and longest way that a robot is pushed on [m]."""
LATE_FROM, LATE_UNTIL, LATE = 6.0, 12.0, 0.09
"""Stamps between which pictures come later, and how much later they are stamped [s]."""
JITTER = 0.1
"""Each picture is stamped later by up to this [s]."""
IN_THE_AIR = 150
"""Grey that the camera sees of a room while the robot is held."""
STRIPE, STRIPE_LIGHT = (0.30, 0.35), 0.3
"""Where a shadow lies that travels with the robot, ahead of it [m], and the light left there."""
LAID_SD, LAID_CELL = 0.010, 0.5
"""How far tape that was laid by hand is off, along each axis, and the distance from which on two
places are off independently [m]."""
SHIFT = 0.10
"""How far away the one piece of tape lies that is elsewhere [m]."""
SPEED = (0.06, 0.20)
"""Lowest and highest speed of drives along a line [m/s]."""
ALONG, BESIDE, LONGEST_WAY = 0.7, 0.05, 0.9
"""Share of the longest edge that is driven, the distance from it, and the longest way [m]."""
REST, TURNING = 1.0, 0.8
"""How long a robot stands at the end of the line [s], and how fast it turns round [rad/s]."""


class DisturbedRobot:
    """A robot to which something happens; without a change, it is the robot itself."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        self.name, self.spec = robot.name, robot.spec
        self._robot = robot
        self.rng = rng
        self.begin = float(rng.uniform(*BEGINS))
        """When it happens, if it happens at one moment [s]."""

    def read(self) -> Reading:
        """Return the next reading."""
        return self.disturbed(self._robot.read())

    def write(self, velocities: Array) -> Array:
        """Pass the requested velocities on."""
        return self._robot.write(velocities)

    def close(self) -> None:
        """Stop the joints."""
        self._robot.close()

    def place(self, pose: Pose2) -> None:
        """Put the robot at a pose in the map, at rest."""
        assert isinstance(self._robot, RepositionableRobot)
        self._robot.place(pose)

    def disturbed(self, reading: Reading) -> Reading:
        """Return a reading as the disturbance leaves it."""
        return reading


class StuckRobot(DisturbedRobot):
    """It stands at an obstacle for two seconds, while its wheels turn on."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        super().__init__(robot, rng)
        self._wanted = np.zeros(len(robot.spec.joints))
        self._added = np.zeros(len(robot.spec.joints))
        """What the wheels turned without moving the robot [rad]."""
        self._before: Reading | None = None
        self._stuck = False

    def write(self, velocities: Array) -> Array:
        """Keep the robot where it is while it is stuck."""
        self._wanted = velocities
        if not self._stuck:
            return super().write(velocities)
        super().write(np.zeros_like(velocities))
        return velocities

    def disturbed(self, reading: Reading) -> Reading:
        """Turn the wheels as they were commanded, whatever the robot does."""
        before, self._before = self._before, reading
        self._stuck = self.begin <= reading.stamp < self.begin + STUCK
        if self._stuck and before is not None:
            turned = reading.positions - before.positions
            self._added += self._wanted * (reading.stamp - before.stamp) - turned
        velocities = self._wanted if self._stuck else reading.velocities
        return replace(reading, positions=reading.positions + self._added, velocities=velocities)


class PushedRobot(DisturbedRobot):
    """Somebody pushes it on, along its way."""

    def disturbed(self, reading: Reading) -> Reading:
        """Push the robot once."""
        if reading.stamp >= self.begin and reading.truth is not None:
            self.begin = math.inf
            self.place(reading.truth @ Pose2(float(self.rng.uniform(*PUSH))))
        return reading


class UnpunctualRobot(DisturbedRobot):
    """Its pictures are stamped late, and delivered no earlier than their stamps say."""

    def __init__(
        self, robot: Robot, rng: np.random.Generator, late: Callable[[float], float]
    ) -> None:
        super().__init__(robot, rng)
        self._late = late
        """How much later the picture of a stamp is stamped [s]."""
        self._waiting: deque[Frame] = deque()
        self._last = -math.inf

    def disturbed(self, reading: Reading) -> Reading:
        """Deliver the newest picture whose time has come."""
        if reading.frame is not None:
            stamp = reading.frame.stamp + self._late(reading.frame.stamp)
            if stamp > self._last:
                self._last = stamp
                self._waiting.append(Frame(stamp, reading.frame.image))
        frame = None
        while self._waiting and self._waiting[0].stamp <= reading.stamp:
            frame = self._waiting.popleft()
        return replace(reading, frame=frame)


class SwappedRobot(DisturbedRobot):
    """The plugs of its two motors are in each other's place."""

    def write(self, velocities: Array) -> Array:
        """Turn each wheel as the other one was told."""
        return super().write(velocities[::-1])[::-1]

    def disturbed(self, reading: Reading) -> Reading:
        """Return what each wheel did as if the other one had done it."""
        positions, velocities = reading.positions[::-1], reading.velocities[::-1]
        return replace(reading, positions=positions, velocities=velocities)


class ReversedRobot(DisturbedRobot):
    """One of its motors is taken for one that is mounted the other way round."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        super().__init__(robot, rng)
        self._signs = np.where(np.arange(len(robot.spec.joints)) == rng.integers(2), -1.0, 1.0)

    def write(self, velocities: Array) -> Array:
        """Turn one wheel back where it was told to go ahead."""
        return super().write(self._signs * velocities) * self._signs

    def disturbed(self, reading: Reading) -> Reading:
        """Return what this wheel did as if it had done the opposite."""
        positions, velocities = self._signs * reading.positions, self._signs * reading.velocities
        return replace(reading, positions=positions, velocities=velocities)


class MirroringRobot(DisturbedRobot):
    """Its camera delivers pictures in which left and right are exchanged, as for a selfie."""

    def disturbed(self, reading: Reading) -> Reading:
        """Mirror the picture."""
        if reading.frame is None:
            return reading
        image = np.ascontiguousarray(reading.frame.image[:, ::-1])
        return replace(reading, frame=Frame(reading.frame.stamp, image))


class FreezingRobot(DisturbedRobot):
    """Its camera delivers one picture again and again for a while, each stamped as a new one."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        super().__init__(robot, rng)
        self._frozen: NDArray[np.uint8] | None = None

    def disturbed(self, reading: Reading) -> Reading:
        """Exchange what is seen for what was seen when it began."""
        if reading.frame is None or not self.begin <= reading.stamp < self.begin + STUCK:
            return reading
        if self._frozen is None:
            self._frozen = reading.frame.image
        return replace(reading, frame=Frame(reading.frame.stamp, self._frozen))


class LiftedRobot(StuckRobot):
    """Somebody lifts it, looks at it while its wheels turn on, and puts it down where it was."""

    def disturbed(self, reading: Reading) -> Reading:
        """Turn the wheels in the air, and see no floor."""
        reading = super().disturbed(reading)
        if reading.frame is None or not self._stuck:
            return reading
        image = np.full_like(reading.frame.image, IN_THE_AIR)
        return replace(reading, frame=Frame(reading.frame.stamp, image))


class RepluggedRobot(DisturbedRobot):
    """The plug of one motor is pulled and put back while it drives: its count begins anew."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        super().__init__(robot, rng)
        self._joint = int(rng.integers(2))
        self._counted = 0.0
        """What the motor had counted when it was put back [rad]."""

    def disturbed(self, reading: Reading) -> Reading:
        """Count from the moment when the plug was put back."""
        if reading.stamp >= self.begin:
            self.begin = math.inf
            self._counted = float(reading.positions[self._joint])
        positions = reading.positions.copy()
        positions[self._joint] -= self._counted
        return replace(reading, positions=positions)


class ShadowedRobot(DisturbedRobot):
    """The shadow of its own mast, or a cable, lies across the floor ahead of it."""

    def __init__(self, robot: Robot, rng: np.random.Generator) -> None:
        super().__init__(robot, rng)
        lens = robot.spec.lens
        rows, columns = np.mgrid[: lens.height, : lens.width]
        pixels = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
        ahead = robot.spec.floor_view.floor_points(pixels)[:, 0]
        with np.errstate(invalid="ignore"):
            within = (ahead > STRIPE[0]) & (ahead < STRIPE[1])
        self._light = np.where(within, STRIPE_LIGHT, 1.0).reshape(lens.height, lens.width)

    def disturbed(self, reading: Reading) -> Reading:
        """Darken the stripe."""
        if reading.frame is None:
            return reading
        image = np.rint(reading.frame.image * self._light).astype(np.uint8)
        return replace(reading, frame=Frame(reading.frame.stamp, image))


def steps_late(robot: Robot, rng: np.random.Generator) -> DisturbedRobot:
    """Return a robot whose pictures are late for six seconds, as those of a busy computer are."""
    return UnpunctualRobot(robot, rng, lambda s: LATE if LATE_FROM <= s < LATE_UNTIL else 0.0)


def jitters(robot: Robot, rng: np.random.Generator) -> DisturbedRobot:
    """Return a robot whose pictures are late by turns."""
    return UnpunctualRobot(robot, rng, lambda _: float(rng.uniform(0, JITTER)))


def laid_by_hand(field: Field, rng: np.random.Generator) -> Field:
    """Return the field with tape that is off everywhere, and differently so."""
    height, width = field.floor.image.shape
    cell = LAID_CELL / field.floor.resolution
    coarse = (math.ceil(height / cell) + 1, math.ceil(width / cell) + 1)
    shifts = [
        cv2.resize(
            rng.normal(0, LAID_SD / field.floor.resolution, coarse).astype(np.float32),
            (width, height),
            interpolation=cv2.INTER_CUBIC,
        )
        for _ in range(2)
    ]
    rows, columns = np.mgrid[:height, :width].astype(np.float32)
    border = field.floor.border
    image = cv2.remap(
        field.floor.image, columns + shifts[0], rows + shifts[1], cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT, borderValue=(border,),
    )  # fmt: skip
    return _painted(field, np.asarray(image, dtype=np.uint8))


def without_piece(field: Field, rng: np.random.Generator) -> Field:
    """Return the field without the tape along its longest edge."""
    return _painted(field, _moved_piece(field, None))


def with_piece_elsewhere(field: Field, rng: np.random.Generator) -> Field:
    """Return the field with the tape along its longest edge 10 cm aside, to one side or another."""
    return _painted(field, _moved_piece(field, SHIFT if rng.random() < 0.5 else -SHIFT))


def longest_edge(field: Field) -> Array:
    """Return the longest edge (2, 2) [m]: its start and its end; the tape is to the left."""
    edge: Array = field.edges[int(np.argmax(lengths(field.edges)))].reshape(2, 2)
    return edge


def _painted(field: Field, image: NDArray[np.uint8]) -> Field:
    return replace(field, floor=replace(field.floor, image=image))


def _moved_piece(field: Field, aside: float | None) -> NDArray[np.uint8]:
    """Return the floor's picture with the piece of tape moved aside [m], or without it."""
    floor, (start, end) = field.floor, longest_edge(field)
    ahead = (end - start) / np.hypot(*(end - start))
    left = np.array([-ahead[1], ahead[0]])
    width = field.tape_width or 0.05
    # What lies across its ends belongs to other pieces.
    near, far = start + width * ahead, end - width * ahead
    affine = floor.pixel_from_map

    def piece(shift: float) -> NDArray[np.int32]:
        margin = 0.002
        corners = [near - margin * left, far - margin * left]
        corners += [far + (width + margin) * left, near + (width + margin) * left]
        pixels = (np.array(corners) + shift * left) @ affine[:, :2].T + affine[:, 2]
        return np.rint(pixels).astype(np.int32)

    inside = np.zeros_like(floor.image)
    cv2.fillConvexPoly(inside, piece(0.0), 1)
    image = np.where(inside > 0, np.uint8(floor.border), floor.image)
    if aside is not None:
        shift = (aside * left) @ affine[:, :2].T
        matrix = np.array([[1, 0, shift[0]], [0, 1, shift[1]]])
        size = (image.shape[1], image.shape[0])
        moved = cv2.warpAffine(floor.image, matrix, size, borderValue=(floor.border,))
        covered = cv2.warpAffine(inside, matrix, size)
        image = np.where(covered > 0, moved, image)
    return np.asarray(image, dtype=np.uint8)


@dataclass(frozen=True)
class LineCourse:
    """To and fro along the longest edge: ahead, a rest, half a turn, a rest, and back."""

    start: Pose2
    """Where the drive begins, in the map."""
    way: float
    """Length of the line that is driven [m]."""
    speed: float
    """[m/s]"""

    @classmethod
    def beside_tape(cls, field: Field, rng: np.random.Generator) -> LineCourse:
        """Return the course on a field, at a speed that is drawn."""
        start, end = longest_edge(field)
        length = float(np.hypot(*(end - start)))
        way = min(ALONG * length, LONGEST_WAY)
        heading = math.atan2(end[1] - start[1], end[0] - start[0])
        first = Pose2(float(start[0]), float(start[1]), heading)
        speed = float(rng.uniform(*SPEED))
        # The tape is to the left, so free floor is to the right.
        return cls(first @ Pose2((length - way) / 2, -BESIDE), way, speed)

    def command(self, stamp: float) -> DriveCommand:
        """Return what is commanded at a stamp [s]."""
        parts = (self.way / self.speed, REST, math.pi / TURNING, REST)
        since_turn = stamp % sum(parts)
        v, omega = 0.0, 0.0
        if since_turn < parts[0]:
            v = self.speed
        elif parts[0] + parts[1] <= since_turn < sum(parts[:3]):
            omega = TURNING
        return DriveCommand(type="drive", v=v, omega=omega)


@dataclass(frozen=True)
class Mishap:
    """What is otherwise than the program believes."""

    settings: Mapping[str, Any] | None = None
    """Settings by their path."""
    robot: Callable[[Robot, np.random.Generator], Robot] | None = None
    """Makes the robot that this befalls."""
    floor: Callable[[Field, np.random.Generator], Field] | None = None
    """Makes the floor that is not as drawn."""
    along_line: bool = False
    """Whether the robot drives along a line, with stops, instead of a figure-eight."""


MISHAPS: Mapping[str, Mishap] = MappingProxyType(
    {
        "straight": Mishap(along_line=True),
        "stuck": Mishap(robot=StuckRobot, along_line=True),
        "pushed-along": Mishap(robot=PushedRobot, along_line=True),
        "late-for-a-while": Mishap(robot=steps_late),
        "late-by-turns": Mishap(robot=jitters),
        "enlarged": Mishap({"sim.camera.floor_scale": 1.03}),
        "shrunk": Mishap({"sim.camera.floor_scale": 0.97}),
        "hand-laid": Mishap(floor=laid_by_hand),
        "piece-elsewhere": Mishap(floor=with_piece_elsewhere),
        "piece-missing": Mishap(floor=without_piece),
        "own-shadow": Mishap(robot=ShadowedRobot),
        "wheels-swapped": Mishap(robot=SwappedRobot),
        "wheel-reversed": Mishap(robot=ReversedRobot),
        "mirrored": Mishap(robot=MirroringRobot),
        "frozen": Mishap(robot=FreezingRobot),
        "lifted": Mishap(robot=LiftedRobot),
        "replugged": Mishap(robot=RepluggedRobot),
        **{
            f"{tone}-{texture}": Mishap({"sim.camera.texture": texture, "sim.camera.tone": tone})
            for texture in ("wood", "lino", "carpet", "concrete")
            for tone in ("light", "dark")
        },
    }
)
"""What each of these conditions is; the others are settings alone (``CONDITIONS``)."""


def mishap_of(condition: str) -> Mishap:
    """Return what a condition does besides settings; nothing if it is settings alone."""
    return MISHAPS.get(condition, Mishap())


def apply_any_condition(config: Config, name: str) -> Config:
    """Return a configuration with the settings of a condition.

    Raises:
        SettingError: the condition is unknown; lists the valid names.
    """
    if name in MISHAPS:
        return with_settings(config, MISHAPS[name].settings or {})
    if name not in CONDITIONS:
        valid = ", ".join((*CONDITIONS, *MISHAPS))
        raise SettingError(f"no condition {name!r}; valid are {valid}")
    return apply_condition(config, name)
