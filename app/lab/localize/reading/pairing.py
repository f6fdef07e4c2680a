"""Pair scans with the odometry at their stamps, in the order of the stamps."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from app.lab.localize.reading.bag import Bag, Message
from app.lab.localize.reading.laser_scan import ScanReader
from app.lab.localize.reading.layout import Chosen, Layout
from app.lab.localize.reading.transforms import Rigid3, frame_name
from robot.geometry import Pose2, interpolate
from robot.scan import Scan
from robot.settings import SettingError

JUMP_S = 10.0
"""A stamp is wrong if its offset jumps by more than this: no message takes that long [s]."""

SET = 10
"""After this many successive wrong stamps with about the same offset, the clock was set."""


class Clock:
    """The clock of one topic. A single wrong stamp must not make all later stamps seem old."""

    def __init__(self) -> None:
        self._ahead: float | None = None
        """Stamp minus the recorder's time, at the last stamp that fitted [s]."""
        self._elsewhere = 0.0
        self._mistakes = 0

    def fits(self, stamp: float, logged: float) -> bool:
        """Whether a stamp [s] fits the time at which the message was recorded [s]."""
        ahead = stamp - logged
        if self._ahead is None or abs(ahead - self._ahead) <= JUMP_S:
            self._ahead, self._mistakes = ahead, 0
            return True
        alike = self._mistakes > 0 and abs(ahead - self._elsewhere) <= JUMP_S
        self._mistakes = self._mistakes + 1 if alike else 1
        self._elsewhere = ahead
        if self._mistakes < SET:
            return False
        self._ahead, self._mistakes = ahead, 0
        return True


KEPT = 2000
"""Number of poses that are remembered: 10 s at 200 Hz."""
WIDEST = 2.0
"""Longest time between two poses over which to interpolate [s]."""
PAST_END = 0.1
"""For this long before the first pose and after the last, the robot is taken to stand there [s]."""


class PoseTrack:
    """The last poses of the robot in the odom frame."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque(maxlen=KEPT)
        self._poses: deque[Pose2] = deque(maxlen=KEPT)
        self.refused = 0
        """Number of poses that were not finite, or not after the previous one."""

    @property
    def last(self) -> float:
        """The newest stamp [s]; -inf if there is none."""
        return self._stamps[-1] if self._stamps else -math.inf

    def add(self, stamp: float, pose: Pose2 | None) -> None:
        """Add a pose; an unusable pose is only counted."""
        if pose is None or not pose.is_finite() or not stamp > self.last:
            self.refused += 1
            return
        self._stamps.append(stamp)
        self._poses.append(pose)

    def at(self, stamp: float) -> Pose2 | None:
        """Return the pose at a stamp, interpolated; None if it is not known."""
        after = bisect_left(self._stamps, stamp)
        if after < len(self._stamps) and self._stamps[after] == stamp:
            return self._poses[after]
        if after in (0, len(self._stamps)):
            if not self._stamps:
                return None
            end = -1 if after else 0
            near = abs(self._stamps[end] - stamp) <= PAST_END
            return self._poses[end] if near else None
        low, high = self._stamps[after - 1], self._stamps[after]
        if high - low > WIDEST:
            return None
        return interpolate(self._poses[after - 1], self._poses[after], (stamp - low) / (high - low))


CLOCKS = ("header", "log")


def require_clock(name: str) -> None:
    """Raise SettingError if this is not one of ``CLOCKS``."""
    if name not in CLOCKS:
        raise SettingError(f"--clock is {name!r}; valid are {', '.join(CLOCKS)}")


MOST_WAITING = 200
"""Largest number of scans that wait for odometry; beyond it, the first is left out."""


class Measurement(NamedTuple):
    """One scan, and the robot's pose by odometry at its stamp."""

    odom_from_robot: Pose2
    scan: Scan


@dataclass
class SkippedCounts:
    """Numbers of scans and poses in a bag that could not be used."""

    unusable_scans: int = 0
    """Scans without ranges or with invalid angles."""
    out_of_order: int = 0
    """Scans whose stamp is not after the previous one, or does not fit the time of recording."""
    without_odometry: int = 0
    odometry: int = 0
    """Poses that were not finite, or whose stamps do not rise."""

    def lines(self) -> list[str]:
        """Return a message for each count that is not zero."""
        given = {
            "scans without usable angles or ranges": self.unusable_scans,
            "scans whose stamps do not rise": self.out_of_order,
            "scans without odometry around them": self.without_odometry,
            "odometry messages that are not finite or whose stamps do not rise": self.odometry,
        }
        return [f"{count} {kind} were left out" for kind, count in given.items() if count]


class Pairing:
    """Reads a bag once, from its beginning."""

    def __init__(self, bag: Bag, chosen: Chosen, layout: Layout, clock: str = "header") -> None:
        """Take stamps from the messages' headers, or (``log``) the times of recording."""
        self._bag, self._chosen, self._layout = bag, chosen, layout
        self._by_log = clock == "log"
        self._scans = ScanReader(layout.base_from_laser)
        self._track = PoseTrack()
        self._waiting: deque[Scan] = deque()
        self._newest = -math.inf
        self._clocks = {name: Clock() for name in chosen.names}
        self.names = chosen.names
        """The topics that are read."""
        self.left_out = SkippedCounts()
        self.messages = 0
        """Number of messages read so far."""
        self.clocks: dict[str, tuple[float, float]] = {}
        """First and last stamp [s] of scans and of odometry."""

    def measurements(self) -> Iterator[Measurement]:
        """Yield all scans that can be used.

        Raises:
            BagError: the bag is damaged.
        """
        for message in self._bag.messages(self._chosen.names):
            self.messages += 1
            if message.topic == self._chosen.scan:
                self._take_scan(message)
            else:
                self._take_odometry(message)
            yield from self._ready(lambda scan: scan.stamp <= self._track.last)
            while len(self._waiting) > MOST_WAITING:
                self._waiting.popleft()
                self.left_out.without_odometry += 1
        yield from self._ready(lambda _: True)
        self.left_out.odometry = self._track.refused

    def _ready(self, due: Callable[[Scan], bool]) -> Iterator[Measurement]:
        while self._waiting and due(self._waiting[0]):
            scan = self._waiting.popleft()
            pose = self._track.at(scan.stamp)
            if pose is None:
                self.left_out.without_odometry += 1
            else:
                yield Measurement(pose, scan)

    def _take_scan(self, message: Message) -> None:
        stamp = self._stamp(message.content.header, message.logged)
        self._note("scans", stamp)
        scan = self._scans.scan(message.content, stamp)
        if scan is None:
            self.left_out.unusable_scans += 1
        elif not (self._fits(message, stamp) and stamp > self._newest):
            self.left_out.out_of_order += 1
        else:
            self._newest = stamp
            self._waiting.append(scan)

    def _take_odometry(self, message: Message) -> None:
        if message.topic == self._chosen.odometry:
            pose = message.content.pose.pose
            self._add(message, message.content.header, pose.position, pose.orientation)
            return
        for transform in message.content.transforms:
            frames = frame_name(transform.header.frame_id), frame_name(transform.child_frame_id)
            if frames == (self._layout.odom_frame, self._layout.base_frame):
                shift, turn = transform.transform.translation, transform.transform.rotation
                self._add(message, transform.header, shift, turn)

    def _add(self, message: Message, header: Any, position: Any, orientation: Any) -> None:
        stamp = self._stamp(header, message.logged)
        self._note("odometry", stamp)
        result = Rigid3.of(position, orientation) if self._fits(message, stamp) else None
        self._track.add(stamp, None if result is None else result.planar())

    def _fits(self, message: Message, stamp: float) -> bool:
        return self._by_log or self._clocks[message.topic].fits(stamp, message.logged)

    def _stamp(self, header: Any, logged: float) -> float:
        """Return the stamp of a header; if it has none, the time of recording."""
        stamp: float = header.stamp.sec + 1e-9 * header.stamp.nanosec
        return logged if self._by_log or stamp <= 0 else stamp

    def _note(self, whose: str, stamp: float) -> None:
        first, last = self.clocks.get(whose, (stamp, stamp))
        self.clocks[whose] = min(first, stamp), max(last, stamp)
