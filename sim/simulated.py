"""Simulated robot: a world that moves, encoders that count and a camera that sees the floor."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.geometry import Array, Pose2, Twist2, interpolate
from robot.interface import Frame, Reading
from robot.settings import check_settings, setting
from sim.encoders import Encoders
from sim.engines import CHOICES
from sim.exposures import Exposures
from sim.floor_camera import CameraSettings, FloorCamera
from sim.imperfections import Imperfections, bumped, draw
from sim.physics import PhysicsSettings
from sim.world import World

HISTORY = 1.2
"""How long true poses are kept for frames that are not yet delivered [s]: the longest delay, half
of the longest exposure and half of a readout."""
PERIOD = 0.02
"""Time between two readings [s]: control at 50 Hz."""


@dataclass(frozen=True)
class SimSettings:
    """Settings of the simulated robot: its camera, its physics, and its imperfections."""

    engine: str = setting(
        "auto",
        "Which physics engine moves the robot; auto is mujoco, or another one that is installed if "
        "that cannot be loaded",
        choices=CHOICES,
    )
    camera: CameraSettings = CameraSettings()
    physics: PhysicsSettings = PhysicsSettings()
    imperfections: Imperfections = Imperfections()

    def __post_init__(self) -> None:
        check_settings(self)


class PastPoses:
    """True poses and twists in the map, by their stamps [s]."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, Pose2, Twist2]] = deque()

    def remember(self, stamp: float, pose: Pose2, twist: Twist2) -> None:
        """Add a pose and a twist; stamps must increase."""
        self._past.append((stamp, pose, twist))
        while self._past[0][0] < stamp - HISTORY:
            self._past.popleft()

    def forget(self) -> None:
        """Remove all poses: the robot was placed elsewhere, so they must not be interpolated."""
        self._past.clear()

    @property
    def newest(self) -> float:
        """The last stamp [s]."""
        return self._past[-1][0]

    def at(self, stamp: float) -> tuple[Pose2, Twist2]:
        """Return the true pose at a stamp, interpolated, and the twist of the next sample.

        Outside the kept time, these are the nearest pose and twist.

        Raises:
            IndexError: no pose has been added.
        """
        start = self._past[0]
        for end in self._past:
            if end[0] >= stamp:
                span = end[0] - start[0]
                part = (stamp - start[0]) / span if span > 0 else 0.0
                return interpolate(start[1], end[1], min(max(part, 0.0), 1.0)), end[2]
            start = end
        return start[1], start[2]


def no_wait(stamp: float) -> None:
    """Do not wait: simulated time runs as fast as it can."""


@dataclass(frozen=True)
class RobotFactory:
    """Makes a simulated robot again, with other imperfections."""

    imperfections: Imperfections
    rng: np.random.Generator
    """As it was before the robot was drawn: other imperfections are larger or smaller errors of the
    same robot."""
    world: Callable[[RobotSpec, Pose2], World]
    """Makes a world of a robot as it truly is, at a pose."""
    engine: str | None = None
    """Name and version of the physics engine in that world; None: it has no forces."""

    def drawn(self, spec: RobotSpec, imperfections: Imperfections) -> RobotSpec:
        """Return the robot as it truly is with these imperfections."""
        return draw(spec.as_drawn, imperfections, copy.deepcopy(self.rng))


class SimulatedRobot:
    """Simulated robot with the interface of a real one; it can also be placed at a pose."""

    def __init__(
        self,
        name: str,
        spec: RobotSpec,
        field: Field,
        *,
        world: World,
        encoders: Encoders,
        camera: CameraSettings,
        rng: np.random.Generator,
        factory: RobotFactory,
        view: FloorView,
        bump: tuple[float, FloorView] | None = None,
        wait: Callable[[float], None] = no_wait,
    ) -> None:
        """Build the robot.

        ``factory`` makes it again with other imperfections; ``view`` is its camera's true view, and
        ``bump`` says from which stamp [s] on it has another one.
        """
        self.name = name
        self.spec = spec
        self._world = world
        self._encoders = encoders
        self._settings = camera
        self.settings = SimSettings(camera=camera, imperfections=factory.imperfections)
        """Camera and imperfections as they are now."""
        self._floor = field.floor
        self._factory = factory
        self._rng = copy.deepcopy(rng)
        self._turned = np.zeros(len(spec.joints))
        """What the wheels had turned in an earlier world [rad]."""
        self._camera = FloorCamera(view, field.floor, camera, rng)
        self._bump = bump
        self._wait = wait
        self.in_real_time = wait is not no_wait  # then nobody may keep it waiting
        self._steps = round(PERIOD / world.step_time)
        if abs(self._steps * world.step_time - PERIOD) > 1e-9:
            raise ValueError(f"{PERIOD} s is no whole number of steps of {world.step_time} s")
        self._command = np.zeros(len(spec.joints))
        self._tick = 0
        self._exposures = Exposures(camera, spec.lens.readout, rng.spawn(1)[0])
        self._past = PastPoses()
        self._renderer = ThreadPoolExecutor(1, "renderer")
        self._rendering: Future[NDArray[np.uint8]] | None = None
        self._due: float | None = None
        self._closed = False
        self._resting: tuple[float, Callable[[], object]] = 0.0, bool
        self._remember()
        self._plan(self.stamp + PERIOD)

    @property
    def engine(self) -> str | None:
        """Name and version of the physics engine that moves it; None: none does."""
        return self._factory.engine

    @property
    def stamp(self) -> float:
        """Simulated time [s]."""
        return self._tick * PERIOD

    def read(self) -> Reading:
        """Advance by one period, or by several while it rests; return what sensors measure then."""
        if self._resting[0] > 0:
            self._stand_still()
        else:
            self._advance()
        frame = self._frame()
        turned = self._turned + self._world.positions
        positions, velocities = self._encoders.read(turned, self.stamp)
        self._wait(self.stamp)
        return Reading(self.stamp, positions, velocities, frame, None, self._world.pose)

    def rest(self, period: float, wanted: Callable[[], object]) -> None:
        """Let all but time stand still until the next reading, if the period [s] is not 0."""
        self._resting = period, wanted

    def _stand_still(self) -> None:
        period, wanted = self._resting
        for _ in range(round(period / PERIOD)):
            self._tick += 1
            self._remember()
            if wanted():
                break
            self._wait(self.stamp)
        self._plan(self.stamp)

    def _advance(self) -> None:
        """Advance the world by one period."""
        step_time = self._world.step_time
        made = 0
        for step in range(1, self._steps + 1):
            since_tick = step * step_time
            # To look at the world takes as long as a step: only where a picture is interpolated.
            near = self._exposures.near(self.stamp + since_tick, 1.5 * step_time)
            if near or step == self._steps:
                self._world.step(self._command, step - made)
                made = step
                self._remember(since_tick)
        self._tick += 1

    def write(self, velocities: Array) -> Array:
        """Command joint velocities (j,) [rad/s]; return them clipped to the joints' limits."""
        if self._closed:
            return np.zeros_like(velocities)
        limits = np.array([joint.max_velocity for joint in self.spec.joints])
        self._command = np.clip(velocities, -limits, limits)
        return self._command

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, at rest; frames not yet delivered are lost."""
        self._world.place(pose)
        self._past.forget()
        self._remember()
        self._exposures.skip(self.stamp)
        self._plan(self.stamp + PERIOD)

    def change(self, settings: SimSettings) -> None:
        """Change camera and imperfections; the robot goes on where it is."""
        view = self._change_robot(settings.imperfections)
        self._settings = settings.camera
        self.settings = SimSettings(camera=settings.camera, imperfections=settings.imperfections)
        rng = copy.deepcopy(self._rng)
        self._camera = FloorCamera(view, self._floor, settings.camera, rng)
        self._exposures = Exposures(settings.camera, self.spec.lens.readout, rng.spawn(1)[0])
        self._exposures.skip(self.stamp)
        self._plan(self.stamp + PERIOD)

    def _change_robot(self, wanted: Imperfections) -> FloorView:
        """Change wheels, slip and mounting; return the camera's true view."""
        factory = self._factory
        before = factory.drawn(self.spec, factory.imperfections)
        true = factory.drawn(self.spec, wanted)
        if true.joints != before.joints or true.track != before.track:
            world = factory.world(true, self._world.pose)
            self._turned = self._turned + self._world.positions
            self._world.close()
            self._world = world
        self._encoders.use(wanted)
        self._factory = replace(factory, imperfections=wanted)
        over = wanted.bump != "none" and self.stamp >= wanted.bump_time
        if over or wanted.bump == "none":
            self._bump = None
        return bumped(true, wanted).floor_view if over else true.floor_view

    def close(self) -> None:
        """Stop the joints; may be called twice."""
        if not self._closed:
            self._closed = True
            self._command = np.zeros(len(self.spec.joints))
            self._renderer.shutdown(cancel_futures=True)
            self._world.close()

    def _remember(self, since_tick: float = 0.0) -> None:
        current = self.stamp + since_tick
        self._past.remember(current, self._world.pose, self._world.twist)

    def _frame(self) -> Frame | None:
        """Return the newest picture, if one has been exposed, read out and delivered by now."""
        frame = None
        if self._due is not None:
            exposed = (self._rendering or self._render(self._due)).result()
            stamp = self._due + self._settings.stamp_error
            frame = Frame(stamp, self._camera.read_out(exposed))
        self._due = None
        if self._resting[0] == 0:
            self._plan(self.stamp + PERIOD)
        return frame

    def _plan(self, until: float) -> None:
        """Decide which picture a reading [s] delivers, and begin it if it has been exposed."""
        self._rendering = None
        self._due = self._exposures.newest(until - self._exposures.until_here)
        if self._due is not None and self._due <= self._past.newest:
            self._rendering = self._render(self._due)

    def _render(self, stamp: float) -> Future[NDArray[np.uint8]]:
        """Render the picture of a stamp while the program goes on."""
        if self._bump is not None and stamp >= self._bump[0]:
            self._camera.turn(self._bump[1])
            self._bump = None
        return self._renderer.submit(self._camera.expose, *self._past.at(stamp))
