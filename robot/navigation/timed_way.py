"""TimedWay: where the robot shall be at each time, and how fast, within the drive's limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.driving.drive_controller import DriveSettings
from robot.geometry import Array, Pose2, Twist2
from robot.navigation.legs import WayLeg
from robot.navigation.settings import NavigationSettings

SHARE = 0.8
"""Share of the drive's accelerations that is planned with; the rest is for the controller."""
TURN_SHARE = 0.85
"""The same of the turning speed."""
STOPPING = 0.8
"""Speed is lost so fast [m/s^2], or as fast as the drive allows: so it stops where it should."""
REST_S = 0.08
"""The robot stands so long between two legs [s]."""
SAMPLE_S = 0.02
"""Time between two moments of a trajectory [s]."""
LOOP_LAPS = 3
"""A loop is planned with so many laps: one to get up speed, one that comes again, one to stop."""


class Wanted(NamedTuple):
    """What is wanted at one time."""

    pose: Pose2
    twist: Twist2


@dataclass(frozen=True, eq=False)
class TimedWay:
    """A way with its times."""

    times: Array
    """(n,) rising from 0 [s]."""
    poses: Array
    """(n, 3) [m, m, rad]; headings do not jump by a turn."""
    twists: Array
    """(n, 2) v and omega [m/s, rad/s]."""
    left: Array
    """(n,) the way that is left [m]."""
    loop: tuple[float, float] | None = None
    """Begin and end of a lap [s], after which the same lap comes again; None ends."""
    room: Array | None = None
    """(n,) the outline's least distance to walls a little ahead [m]; None is not known."""
    bound: float = math.inf
    """Where the robot knows its place so well [m], its outline comes to no wall; inf is any."""
    narrow: str = ""
    """Why it comes nearer to walls than that, in words for people; empty if it does not."""

    @property
    def duration(self) -> float:
        """How long it takes [s]; infinite if it is driven round and round."""
        return float(self.times[-1]) if self.loop is None else math.inf

    @property
    def rest_s(self) -> float:
        """How long it stands between its legs [s]."""
        return REST_S * (len(self._rests) - 1)

    @property
    def lap_points(self) -> Array:
        """(n, 2) the way [m], and of a loop one lap."""
        shown = self.times <= (self.times[-1] if self.loop is None else self.loop[1])
        return self.poses[shown, :2].copy()

    @property
    def goal(self) -> Pose2:
        """Where it ends."""
        return Pose2.from_array(self.poses[-1])

    def at(self, time: float) -> Wanted:
        """Return what is wanted at a time [s]; before the start and after the end it stands."""
        place, share = self._place(time)
        low, high = self.poses[place], self.poses[place + 1]
        x, y, theta = (low + share * (high - low)).tolist()
        v, omega = self.twists[place], self.twists[place + 1]
        twist = v + share * (omega - v)
        return Wanted(Pose2(x, y, theta), Twist2(float(twist[0]), float(twist[1])))

    def leg_at(self, time: float) -> tuple[int, int]:
        """Return the first and the last point of the leg at a time: between them it never stands.

        Points between which only the heading changes are a leg, too.
        """
        place, _ = self._place(time)
        rests = self._rests
        low = int(np.searchsorted(rests, place, side="right")) - 1
        return (int(rests[low]) + 1 if low >= 0 else 0), int(rests[low + 1])

    @cached_property
    def _rests(self) -> NDArray[np.intp]:
        """The last point of each leg."""
        gaps = np.diff(self.times) >= REST_S - 1e-6
        return np.append(np.flatnonzero(gaps), len(self.times) - 1)

    def is_turn(self, low: int, high: int) -> bool:
        """Whether the robot turns on the spot between two points."""
        return bool((self.poses[low : high + 1, :2] == self.poses[low, :2]).all())

    def is_backwards(self, low: int, high: int) -> bool:
        """Whether the robot drives backwards between two points of a leg."""
        return bool(self.twists[low : high + 1, 0].sum() < 0)

    def ahead_of(self, time: float, last: int) -> Array:
        """Return the poses (n, 3) from a time [s] on to the last point of a leg."""
        place, _ = self._place(time)
        return self.poses[place : max(last, place) + 1]

    def nearest_time(self, pose: Pose2, since: float, until: float) -> float:
        """Return when between two times [s] the way is nearest to a pose."""
        low, _ = self._place(since)
        high, _ = self._place(until)
        poses = self.poses[low : high + 2]
        if len(poses) < 2:
            return since
        step = np.diff(poses[:, :2], axis=0)
        length = np.maximum((step**2).sum(axis=1), 1e-18)
        beside = np.array([pose.x, pose.y]) - poses[:-1, :2]
        share = np.clip((beside * step).sum(axis=1) / length, 0.0, 1.0)
        away = np.hypot(*(beside - share[:, None] * step).T)
        best = int(np.argmin(away))
        begin, end = self.times[low + best], self.times[low + best + 1]
        shifted = since - self._wrapped(since)
        return max(float(begin + share[best] * (end - begin)) + shifted, since)

    def room_at(self, time: float) -> float:
        """Return the outline's least distance to walls a little after a time [m]; 0 if unknown."""
        return 0.0 if self.room is None else float(self.room[self._place(time)[0]])

    def left_at(self, time: float) -> float:
        """Return the way that is left at a time [m], in a loop of the lap."""
        place, share = self._place(time)
        low, high = self.left[place], self.left[place + 1]
        beyond = 0.0 if self.loop is None else np.interp(self.loop[1], self.times, self.left)
        return max(float(low + share * (high - low) - beyond), 0.0)

    def time_left(self, time: float) -> float:
        """Return the time from a time on to its end, in a loop to that of the lap [s]."""
        end = self.times[-1] if self.loop is None else self.loop[1]
        return max(float(end) - self._wrapped(time), 0.0)

    def _wrapped(self, time: float) -> float:
        if self.loop is None or time < self.loop[1]:
            return time
        begin, end = self.loop
        return begin + (time - begin) % (end - begin)

    def _place(self, time: float) -> tuple[int, float]:
        """Return the point before a time, and how far the time is on the way to the next one."""
        time = self._wrapped(time)
        place = int(np.searchsorted(self.times, time, side="right")) - 1
        place = min(max(place, 0), len(self.times) - 2)
        low, high = float(self.times[place]), float(self.times[place + 1])
        return place, min(max((time - low) / (high - low), 0.0), 1.0)


@dataclass(frozen=True)
class Limits:
    """How fast the robot may be."""

    speed: float
    """[m/s]"""
    gain: float
    """Of speed in a second [m/s^2]."""
    loss: float
    """[m/s^2]"""
    turning: float
    """[rad/s]"""
    turning_gain: float
    """Of turning speed in a second, also its loss [rad/s^2]."""
    rim: float
    """Highest speed of a wheel over the floor [m/s]."""
    half_track: float
    """Half the distance between the wheels [m]."""

    @classmethod
    def of(
        cls, drive: DriveSettings, settings: NavigationSettings, rim: float, track: float
    ) -> Limits:
        """Return what both settings allow, with some left for the controller."""
        return cls(
            speed=min(settings.desired_linear_vel, drive.max_velocity),
            gain=SHARE * drive.max_acceleration,
            loss=min(SHARE * drive.max_deceleration, STOPPING),
            turning=min(
                settings.rotate_to_heading_angular_vel, TURN_SHARE * drive.max_angular_velocity
            ),
            turning_gain=min(
                settings.max_angular_accel, SHARE * drive.max_angular_acceleration,
                SHARE * drive.max_angular_deceleration,
            ),
            rim=TURN_SHARE * rim,
            half_track=track / 2,
        )  # fmt: skip

    def along_curve(self, speed: float, drive: DriveSettings) -> Limits:
        """Return the limits along a closed curve, at a speed [m/s].

        Its turning speed may change as fast as the drive allows: the curve is given, and where it
        bends the other way the robot would else slow down.
        """
        return replace(
            self,
            speed=min(speed, drive.max_velocity),
            turning=TURN_SHARE * drive.max_angular_velocity,
            turning_gain=SHARE
            * min(drive.max_angular_acceleration, drive.max_angular_deceleration),
        )


def timed(legs: tuple[WayLeg, ...], limits: Limits) -> TimedWay:
    """Return legs with times: as fast as the limits allow, at rest between two legs."""
    parts = [_turn_timed(leg, limits) if leg.on_spot else _curve_timed(leg, limits) for leg in legs]
    begin, times, poses, twists = 0.0, [], [], []
    for leg_times, leg_poses, leg_twists in parts:
        times.append(begin + leg_times)
        poses.append(leg_poses)
        twists.append(leg_twists)
        begin += float(leg_times[-1]) + REST_S
    all_poses = np.concatenate(poses)
    steps = np.hypot(*np.diff(all_poses[:, :2], axis=0).T)
    left = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    return TimedWay(np.concatenate(times), all_poses, np.concatenate(twists), left)


def timed_loop(lap: tuple[WayLeg, ...], limits: Limits) -> TimedWay:
    """Return a lap with times that comes again and again; one single leg without a stop."""
    if len(lap) > 1:
        way = timed(lap, limits)
        # The rest after the last leg is as long as between two.
        end = float(way.times[-1]) + REST_S
        return replace(
            way,
            times=np.append(way.times, end),
            poses=np.concatenate([way.poses, way.poses[-1:]]),
            twists=np.concatenate([way.twists, np.zeros((1, 2))]),
            left=np.append(way.left, 0.0),
            loop=(0.0, end),
        )
    poses = lap[0].poses
    around = np.array([0.0, 0.0, poses[-1, 2] - poses[0, 2]])
    laps = [poses, *(poses[1:] + number * around for number in range(1, LOOP_LAPS))]
    way = timed((WayLeg(np.concatenate(laps)),), limits)
    # It gets up speed in the first lap and stands at the end of the last one.
    ends = way.left[0] * np.array([LOOP_LAPS - 1.0, LOOP_LAPS - 2.0]) / LOOP_LAPS
    begin, end = np.interp(ends, way.left[::-1], way.times[::-1]).tolist()
    return replace(way, loop=(begin, end))


def _turn_timed(leg: WayLeg, limits: Limits) -> tuple[Array, Array, Array]:
    """Turn with a trapezoid of the turning speed."""
    angle = float(leg.poses[-1, 2] - leg.poses[0, 2])
    gain = limits.turning_gain
    peak = min(limits.turning, math.sqrt(gain * abs(angle)))
    ramp, even = peak / gain, abs(angle) / peak - peak / gain
    times = np.linspace(0.0, 2 * ramp + even, max(3, math.ceil((2 * ramp + even) / SAMPLE_S) + 1))
    omega = np.minimum(np.minimum(times, times[-1] - times) * gain, peak)
    rising = np.minimum(times, ramp)
    falling = np.maximum(times - ramp - even, 0.0)
    turned = gain * rising**2 / 2 + peak * (np.clip(times - ramp, 0.0, even))
    turned += peak * falling - gain * falling**2 / 2
    sign = math.copysign(1.0, angle)
    poses = np.tile(leg.poses[0], (len(times), 1))
    poses[:, 2] += sign * turned
    return times, poses, np.column_stack([np.zeros_like(times), sign * omega])


def _curve_timed(leg: WayLeg, limits: Limits) -> tuple[Array, Array, Array]:
    """Drive along a curve as fast as its bends allow."""
    poses = leg.poses
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    bend = np.gradient(poses[:, 2], along) if len(poses) > 2 else np.zeros(len(poses))
    change = np.abs(np.gradient(bend, along)) if len(poses) > 2 else np.zeros(len(poses))
    speed = np.minimum(limits.speed, limits.turning / np.maximum(np.abs(bend), 1e-9))
    speed = np.minimum(speed, np.sqrt(limits.turning_gain / np.maximum(change, 1e-9)))
    speed = np.minimum(speed, limits.rim / (1 + limits.half_track * np.abs(bend)))
    squares = np.minimum(speed, limits.speed) ** 2
    squares[0] = squares[-1] = 0.0
    for index in range(1, len(squares)):
        gained = 2 * limits.gain * steps[index - 1]
        squares[index] = min(squares[index], squares[index - 1] + gained)
    for index in range(len(squares) - 2, -1, -1):
        lost = 2 * limits.loss * steps[index]
        squares[index] = min(squares[index], squares[index + 1] + lost)
    speed = np.sqrt(squares)
    # Between two points the speed's square changes evenly over the way, so the speed over time.
    reached = np.concatenate([[0.0], np.cumsum(2 * steps / (speed[:-1] + speed[1:]))])
    times = np.linspace(0.0, reached[-1], max(3, math.ceil(reached[-1] / SAMPLE_S) + 1))
    place = np.clip(np.searchsorted(reached, times, side="right") - 1, 0, len(steps) - 1)
    since = times - reached[place]
    gained = (speed[place + 1] - speed[place]) / (reached[place + 1] - reached[place])
    way = np.clip(along[place] + since * (speed[place] + gained * since / 2), 0.0, along[-1])
    v = np.maximum(speed[place] + gained * since, 0.0)
    timed_poses = np.column_stack([np.interp(way, along, axis) for axis in poses.T])
    sign = -1.0 if leg.backwards else 1.0
    return times, timed_poses, np.column_stack([sign * v, v * np.interp(way, along, bend)])
