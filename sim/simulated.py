"""A simulated robot: a world that moves, encoders that count and a camera that sees the floor."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from robot.camera import FloorView
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.geometry import Array, Pose2, Twist2, interpolate
from robot.interface import Frame, Reading
from sim.encoders import Encoders
from sim.floor_camera import CameraSettings, FloorCamera
from sim.world import World

PERIOD = 0.02
"""Time between two readings [s]: control at 50 Hz."""

HISTORY = 1.2
"""How long true poses are kept for frames that are still under way [s]: the longest delay, half of
the longest exposure and half of a readout."""


def no_wait(stamp: float) -> None:
    """Let simulated time run as fast as it can."""


class SimulatedRobot:
    """Behind the same interface as a real one, and it can be put elsewhere."""

    def __init__(
        self,
        name: str,
        spec: RobotSpec,
        field: Field,
        world: World,
        encoders: Encoders,
        camera: CameraSettings,
        rng: np.random.Generator,
        wait: Callable[[float], None] = no_wait,
        view: FloorView | None = None,
    ) -> None:
        """Put it together; ``view`` is how its camera is truly mounted, if not as described."""
        self.name = name
        self.spec = spec
        self._world = world
        self._encoders = encoders
        self._settings = camera
        self._camera = FloorCamera(view or spec.floor_view, field.floor, camera, rng)
        self._wait = wait
        self._steps = round(PERIOD / world.step_time)
        if abs(self._steps * world.step_time - PERIOD) > 1e-9:
            raise ValueError(f"{PERIOD} s is no whole number of steps of {world.step_time} s")
        self._command = np.zeros(len(spec.joints))
        self._tick = 0
        self._frames = 0
        self._past: deque[tuple[float, Pose2, Twist2]] = deque()
        self._closed = False
        self._remember()

    @property
    def stamp(self) -> float:
        """Simulated time [s]."""
        return self._tick * PERIOD

    def read(self) -> Reading:
        """Advance by one period and tell what the sensors say."""
        for step in range(self._steps):
            self._world.step(self._command)
            self._remember((step + 1) * self._world.step_time)
        self._tick += 1
        frame = self._frame()
        positions, velocities = self._encoders.read(self._world.positions, self.stamp)
        self._wait(self.stamp)
        return Reading(self.stamp, positions, velocities, frame, None, self._world.pose)

    def write(self, velocities: Array) -> Array:
        """Ask for joint velocities (j,) [rad/s]; returns them within the joints' limits."""
        if self._closed:
            return np.zeros_like(velocities)
        limits = np.array([joint.max_velocity for joint in self.spec.joints])
        self._command = np.clip(velocities, -limits, limits)
        return self._command

    def place(self, pose: Pose2) -> None:
        """Put the robot at a pose in the map, standing; frames under way are lost."""
        self._world.place(pose)
        self._past.clear()
        self._remember()
        self._frames = int(self.stamp * self._settings.frame_rate) + 1

    def close(self) -> None:
        """Stop the joints; may be called twice."""
        if not self._closed:
            self._closed = True
            self._command = np.zeros(len(self.spec.joints))
            self._world.close()

    def _remember(self, since_tick: float = 0.0) -> None:
        now = self.stamp + since_tick
        self._past.append((now, self._world.pose, self._world.twist))
        while self._past[0][0] < now - HISTORY:
            self._past.popleft()

    def _frame(self) -> Frame | None:
        """The newest picture, if one has been exposed, read out and handed over by now."""
        until_here = self._settings.exposure / 2 + self.spec.lens.readout / 2
        newest = self.stamp + 1e-9 - until_here - self._settings.delay
        exposed = None
        # A camera that is quicker than the readings: only the newest picture is handed out.
        while self._frames / self._settings.frame_rate <= newest:
            exposed = self._frames / self._settings.frame_rate
            self._frames += 1
        if exposed is None:
            return None
        pose, twist = self._at(exposed)
        return Frame(exposed + self._settings.stamp_error, self._camera.picture(pose, twist))

    def _at(self, stamp: float) -> tuple[Pose2, Twist2]:
        """True pose and twist at a moment that is still remembered."""
        start = self._past[0]
        for end in self._past:
            if end[0] >= stamp:
                span = end[0] - start[0]
                part = (stamp - start[0]) / span if span > 0 else 0.0
                return interpolate(start[1], end[1], min(max(part, 0.0), 1.0)), end[2]
            start = end
        return start[1], start[2]
