"""Speed controller of one wheel: computes the duty from the wanted speed and the encoder.

The loop runs on the computer, a hundred times a second. A model wheel predicts the shaft's motion,
with the motor's lag and the wire's delay. The duty has two parts: the duty for the wanted speed
(feed forward), and a correction by how far the shaft is from the model wheel. A wheel that was held
back catches up, so both wheels of a robot cover their distances together. A mere delay is no error,
so nothing accumulates that would overshoot.

The firmware has a PID controller of its own. It was measured beside this one (`brickpose bench
wheels`) and is slower: its integral is never cleared, and the motors report their speed in steps of
10 degrees/s.
"""

from __future__ import annotations

import math
from collections import deque

from robot.description.wiring import MotorKind
from robot.hat.joint_track import JointTrack

WIRE_DELAY = 0.012
"""Time from computing a duty until the motor has it [s]: the time of a line of 60 bytes, and half a
firmware tick."""

NOMINAL_SUPPLY = 7.2
"""The voltage of the data sheets [V]."""

KICK_S = 0.03
"""How long a wheel that stood gets its breakaway duty [s]."""

RAIL = 0.9
"""Share of the supply that reaches the motors: 7.2 of 8 V."""

LOWEST_V = 4.0
"""Below this supply voltage the duty is not raised any further [V]."""

LARGEST_LAG = 25.0
"""A wheel this far behind is blocked; it does not make up for more [degree]."""

HELD_S = 0.2
HELD_TRAVEL = 5.0
"""A shaft is blocked if it stays on one degree for HELD_S [s] while it should have turned by
HELD_TRAVEL [degree]."""

STUCK_S = 0.05
STUCK_TRAVEL = 1.5
"""A shaft sticks if it stays on one degree for longer than STUCK_S [s] while it should have turned
by more than STUCK_TRAVEL [degree]."""

PUSH, MOST_PUSH = 0.1, 0.25
"""A shaft that sticks gets so much more duty for each further degree that it should have turned,
and so much at most: wheels that carry a robot stick more than a free motor."""

GAP_S = 0.1
"""If no duty was computed for this long, or no sample came, the program or what is behind the port
stood still: what the wheel did meanwhile is not known, and says nothing of a blocked wheel [s]."""

TURNING_SPAN = 0.03
"""When a wheel is to turn again, its speed over this time shows whether it still turns [s]."""

STANDING = 1.0
"""Below this speed a wheel counts as standing [degree/s]."""


class SpeedLoop:
    """Controls one motor; all angles are at the shaft, positive as the motor counts."""

    def __init__(self, kind: MotorKind, position_gain: float) -> None:
        self._kind = kind
        self._gain = position_gain
        self._speed = 0.0
        """Speed of the model wheel [degree/s]."""
        self._past: deque[tuple[float, float]] = deque()
        """Stamps and angles of the model wheel; empty while it rests."""
        self._began = -math.inf
        """When the wheel last began to turn from standstill [s]."""
        self._seen = 0.0
        """The last shaft angle that differed from the one before [degree]."""
        self._seen_at = -math.inf
        self._heard_at = -math.inf
        """Stamp of the last sample [s]."""
        self._travel = 0.0
        """How far the model wheel has turned since then [degree]."""
        self.duty = 0.0
        """The last duty, -1 to 1."""

    def rest(self) -> None:
        """Set the duty to zero and forget the lag."""
        self._speed = self.duty = self._travel = 0.0
        self._past.clear()

    @property
    def is_held(self) -> bool:
        """Whether the shaft does not move, by sample after sample, although it should."""
        return self._travel > HELD_TRAVEL and self._heard_at - self._seen_at > HELD_S

    def update(
        self, wanted: float, current: float, track: JointTrack, supply_v: float | None
    ) -> float:
        """Return the duty from now on, -1 to 1.

        Args:
            wanted: requested speed [degree/s].
            current: the program's clock [s].
            track: measured angles of the shaft.
            supply_v: the board's supply [V], None while it is not known.
        """
        if wanted == 0:
            self.rest()  # duty 0 is the brake
            return self.duty
        if self._past and current - self._past[-1][0] > GAP_S:
            self._past.clear()
        if not self._past:
            self._begin(current, track)
        ahead = wanted + self._gain * self._lag(wanted, current, track)
        kicked = current - self._began < KICK_S
        friction = self._kind.breakaway if kicked else self._kind.friction
        push = math.copysign(friction + self._more, ahead) if abs(ahead) > STANDING else 0.0
        volts = 1.0 if supply_v is None else RAIL * max(supply_v, LOWEST_V) / NOMINAL_SUPPLY
        duty = (ahead / self._kind.free_speed + push) / volts
        self.duty = min(max(duty, -1.0), 1.0)
        return self.duty

    def _begin(self, current: float, track: JointTrack) -> None:
        self._speed = track.speed(TURNING_SPAN)
        stood = abs(self._speed) < STANDING
        self._began = current if stood else -math.inf
        self._seen, self._seen_at, self._travel = track.angle, current, 0.0
        self._heard_at = track.newest_stamp
        self._past.append((current, track.angle))

    @property
    def _more(self) -> float:
        """Duty that moves a shaft that sticks, by sample after sample; 0 while it turns."""
        if self._heard_at - self._seen_at <= STUCK_S:
            return 0.0
        return min(max(PUSH * (self._travel - STUCK_TRAVEL), 0.0), MOST_PUSH)

    def _lag(self, wanted: float, current: float, track: JointTrack) -> float:
        """Advance the model wheel; return how far the shaft is behind it [degree]."""
        earlier, angle = self._past[-1]
        passed = max(current - earlier, 0.0)
        kept = math.exp(-passed / self._kind.time_constant)
        turned = wanted * passed + (self._speed - wanted) * self._kind.time_constant * (1 - kept)
        angle += turned
        self._travel += abs(turned)
        self._speed = wanted + (self._speed - wanted) * kept
        self._past.append((current, angle))
        sample = track.newest
        if sample is None:
            return 0.0
        if sample.angle != self._seen or sample.stamp - self._heard_at > GAP_S:
            self._seen, self._seen_at, self._travel = sample.angle, current, 0.0
        self._heard_at = sample.stamp
        lag = self._interpolated(sample.stamp - WIRE_DELAY) - sample.angle
        return self._bounded(lag)

    def _interpolated(self, stamp: float) -> float:
        """Return the model wheel's angle at a stamp [degree]; forget older moments."""
        while len(self._past) > 2 and self._past[1][0] <= stamp:
            self._past.popleft()
        (a, low), (b, high) = self._past[0], self._past[min(1, len(self._past) - 1)]
        part = min(max((stamp - a) / (b - a), 0.0), 1.0) if b > a else 0.0
        return low + part * (high - low)

    def _bounded(self, lag: float) -> float:
        """Return the lag within its bounds; forget the rest of it."""
        excess = lag - min(max(lag, -LARGEST_LAG), LARGEST_LAG)
        if excess:
            self._past = deque((stamp, angle - excess) for stamp, angle in self._past)
        return lag - excess
