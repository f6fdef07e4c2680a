"""The programme of a calibration's drive: turns, arcs and straights both ways, near its start."""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import accumulate

from robot.geometry import Twist2

USUAL_S = 60.0
"""How long a calibration drives by default [s]."""
LONGEST_S = 120.0
"""How long it drives at most until the camera's place is known [s]."""
KNOWN_SD = 0.0003
"""The camera's place across the robot, ``camera_y``, is known then: standard deviation [m]."""
RAMP_S = 0.3
"""Time in which a part reaches its speed, and in which it ends [s]."""

PARTS = (
    (2.0, 0.15, 1.0),
    (2.0, -0.15, -1.0),
    (5.8, 0.0, 1.15),
    (2.0, 0.10, 0.0),
    (2.0, -0.10, 0.0),
    (5.8, 0.0, -1.15),
    (2.0, 0.15, -1.0),
    (2.0, -0.15, 1.0),
    (5.8, 0.0, 1.15),
    (5.8, 0.0, -1.15),
)
"""Duration [s], speed [m/s] and turning rate [rad/s] of each part; they repeat.

What leads away leads back, as nobody knows yet how far a wheel rolls. Turns both ways tell the
separation of the wheels and the camera's place, straights its yaw, and every start and stop the
pictures' delay. The first twenty seconds have one of each. Turns are two thirds of the time, as
they tell ``camera_y``, which is known least: with a third, it was off by 0.78 mm after 20 s and by
0.39 mm after 60 s, with two thirds by 0.41 and 0.27 mm (root mean square of eleven hand-built
robots, seeds 900 to 910). With turns alone after 35 s it is known less: wheels of different sizes
shift what a robot turns about, too, and only straights and arcs tell their sizes apart."""

ENDS = tuple(accumulate(duration for duration, _, _ in PARTS))
"""When each part ends [s]."""


def velocity(elapsed: float) -> Twist2:
    """Return the robot's velocity at a time after the start [s]."""
    begin, end, (_, v, omega) = _part(elapsed)
    part = max(0.0, min(1.0, (elapsed - begin) / RAMP_S, (end - elapsed) / RAMP_S))
    return Twist2(part * v, part * omega)


def rest_after(elapsed: float) -> float:
    """Return when the robot stands next, between two parts [s]: always later."""
    _, end, _ = _part(elapsed)
    return end


def _part(elapsed: float) -> tuple[float, float, tuple[float, float, float]]:
    """Return when the part of a time began, when it ends [s], and the part."""
    cycle = math.floor(elapsed / ENDS[-1]) * ENDS[-1]
    # Times are compared as they are added: otherwise one that is rounded ends where it began.
    bounds = [cycle, *(cycle + end for end in ENDS), cycle + ENDS[-1] + ENDS[0]]
    place = bisect_right(bounds, elapsed) - 1
    return bounds[place], bounds[place + 1], PARTS[place % len(PARTS)]
