"""The programme of a calibration's drive: turns, arcs and straights both ways, near its start."""

from __future__ import annotations

from robot.geometry import Twist2

USUAL_S = 60.0
"""How long a calibration drives [s]."""
RAMP_S = 0.3
"""Time in which a part reaches its speed, and in which it ends [s]."""

PARTS = (
    (2.0, 0.15, 1.0),
    (2.0, -0.15, -1.0),
    (5.8, 0.0, 1.15),
    (2.0, 0.10, 0.0),
    (4.0, -0.10, 0.0),
    (2.0, 0.10, 0.0),
    (2.0, 0.15, -1.0),
    (2.0, -0.15, 1.0),
    (5.8, 0.0, -1.15),
    (3.0, 0.10, 0.6),
    (3.0, -0.10, -0.6),
    (3.0, 0.10, -0.6),
    (3.0, -0.10, 0.6),
)
"""Duration [s], speed [m/s] and turning rate [rad/s] of each part. What leads away leads back, as
nobody knows yet how far a wheel rolls. Turns both ways tell the separation of the wheels and the
camera's place, straights its yaw, and every start and stop the pictures' delay."""

CYCLE_S = sum(duration for duration, _, _ in PARTS)


def velocity(elapsed: float) -> Twist2:
    """Return the robot's velocity at a time after the start [s]; the programme repeats."""
    within = elapsed % CYCLE_S
    for duration, v, omega in PARTS:
        if within < duration:
            part = min(1.0, within / RAMP_S, (duration - within) / RAMP_S)
            return Twist2(part * v, part * omega)
        within -= duration
    return Twist2()
