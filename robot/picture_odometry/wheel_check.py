"""Whether wheels tell what the floor does: stuck, slipping, pushed and lifted robots, by name."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from robot.geometry import Pose2
from robot.picture_odometry.odometer import PictureMotion


class WheelState(Enum):
    """What the floor says of the wheels."""

    UNKNOWN = "unknown"
    """The pictures do not show how the floor moves."""
    ROLLING = "rolling"
    """They roll as they turn."""
    STUCK = "stuck"
    """They turn, and the robot stands."""
    SLIPPING = "slipping"
    """The robot moves otherwise than they turn."""
    PUSHED = "pushed"
    """The robot moves more than they turn."""
    LIFTED = "lifted"
    """The floor came nearer or went away."""


WINDOW_S = 0.14
"""Time over which motions are compared [s]: what is wrong has to be told within 0.3 s, and of a
shorter time a slow robot's millimetres are few."""
LEAST_M = 0.0035
"""By so much the floor and the wheels have to differ in this time [m]: a robot that begins to move
or stops has 2 mm of play and lag."""
SHARE = 0.3
"""And by this share of the way: tyres that are worn and floors that are smooth are told by others,
who have more time."""
NEWEST_S = 0.06
"""What is wrong is named by this time [s]: before, the wheels may still have rolled."""
STANDS = 0.25
"""A robot stands if it moves by less than this share of the wheels' way."""
SIGMAS = 4.0
"""And by so many standard deviations of what is measured."""
ARM_M = 0.056
"""A turn counts by the way of a wheel: half the distance between them [m]."""
GROWN = 0.025
"""By this share the floor has to look larger or smaller in the window: 4 mm of 160."""
HOLDS_S = 0.5
"""A state that is told holds at least for this time [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    end: float
    seconds: float
    way: np.ndarray[tuple[int], np.dtype[np.float64]]
    """(3,) by the picture [m], a turn by ``ARM_M``."""
    by_wheels: np.ndarray[tuple[int], np.dtype[np.float64]]
    variance: np.ndarray[tuple[int], np.dtype[np.float64]]
    larger: float
    larger_variance: float


class WheelCheck:
    """Compares motion by pictures with that by wheels; one thread calls it."""

    def __init__(self) -> None:
        self.state = WheelState.UNKNOWN
        self._steps: deque[_Step] = deque()
        self._told = -math.inf

    def add(self, motion: PictureMotion) -> WheelState:
        """Add the motion of a picture; return what is known now."""
        if motion.seen < 2:
            self._steps.clear()
            state = WheelState.UNKNOWN
        else:
            self._steps.append(_step_of(motion))
            while self._steps and self._steps[0].end < motion.end - WINDOW_S:
                self._steps.popleft()
            state = self._judged()
        if state in (WheelState.ROLLING, WheelState.UNKNOWN):
            if motion.end < self._told + HOLDS_S and self.state is not WheelState.UNKNOWN:
                return self.state
        else:
            self._told = motion.end
            if self.state is WheelState.LIFTED:
                state = self.state  # what a robot in the air sees of its wheels means nothing
        self.state = state
        return state

    def _judged(self) -> WheelState:
        seconds = sum(step.seconds for step in self._steps)
        if seconds < 0.6 * WINDOW_S:
            return WheelState.ROLLING if self.state is WheelState.ROLLING else WheelState.UNKNOWN
        larger = sum(step.larger for step in self._steps)
        sure = math.sqrt(sum(step.larger_variance for step in self._steps))
        if abs(larger) > max(GROWN, SIGMAS * sure):
            return WheelState.LIFTED
        apart, _, turned, sd = _ways(self._steps)
        if apart < max(LEAST_M, SHARE * turned, SIGMAS * sd):
            return WheelState.ROLLING
        since = self._steps[-1].end - NEWEST_S
        _, moved, turned, _ = _ways(step for step in self._steps if step.end > since)
        if moved < STANDS * turned:
            return WheelState.STUCK
        return WheelState.PUSHED if moved > turned * (1 + SHARE) else WheelState.SLIPPING


def _ways(steps: Iterable[_Step]) -> tuple[float, float, float, float]:
    """Return how far picture and wheels are apart, each one's way, and the first one's sd [m].

    What is not seen of the motion is left out: its variance is so large that it tells nothing.
    """
    listed = list(steps)
    variance = np.sum([step.variance for step in listed], axis=0)
    known = variance < LEAST_M**2
    way = np.sum([step.way for step in listed], axis=0)[known]
    by_wheels = np.sum([step.by_wheels for step in listed], axis=0)[known]
    ways = (float(np.linalg.norm(each)) for each in (way - by_wheels, way, by_wheels))
    apart, moved, turned = ways
    return apart, moved, turned, math.sqrt(float(variance[known].sum()))


def _step_of(motion: PictureMotion) -> _Step:
    def ways(pose: Pose2) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        return pose.to_array() * (1.0, 1.0, ARM_M)

    variance = np.diag(motion.covariance) * (1.0, 1.0, ARM_M**2)
    grown = motion.larger if math.isfinite(motion.larger_sd) else 0.0
    spread = motion.larger_sd**2 if math.isfinite(motion.larger_sd) else 0.0
    return _Step(
        motion.end, motion.end - motion.begin, ways(motion.motion), ways(motion.predicted),
        variance, grown, spread,
    )  # fmt: skip
