"""Pair scans with the odometry at their stamps, in the order of the stamps."""

from __future__ import annotations

import math
import zlib
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from app.features.lab.localize.reading.bag import Bag, BagMessage
from app.features.lab.localize.reading.clocks import JUMP_S, Stream, TopicTimeline, one_clock
from app.features.lab.localize.reading.delay import measured_delay, pairs_to_compare
from app.features.lab.localize.reading.laser_scan import ScanReader
from app.features.lab.localize.reading.layout import Chosen, Layout
from app.features.lab.localize.reading.odometry import OdometryTrack
from app.features.lab.localize.reading.transforms import Rigid3, frame_name
from app.features.lab.localize.reading.units import SAMPLES, UnitEvidence, require_metres
from robot.geometry import Pose2
from robot.scan import Scan
from robot.settings import SettingError

CLOCKS = ("header", "log")
SCANS, ODOMETRY = "scans", "odometry"
"""Names of the streams: odometry may come from several topics of transforms."""
LEAST_LAG_S = 0.2
"""Scans that arrive so much later than odometry are remarked [s]."""
Key = tuple[float, float]
"""When a message was recorded, and the stamp of its header [s]; after a step back of the clock it
may come twice."""


def require_clock(name: str) -> None:
    """Raise SettingError if this is not one of ``CLOCKS``."""
    if name not in CLOCKS:
        raise SettingError(f"--clock is {name!r}; valid are {', '.join(CLOCKS)}")


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
    absurd_odometry: int = 0
    """Poses to which no robot can have come."""

    def lines(self) -> list[str]:
        """Return a message for each count that is not zero."""
        given = {
            "scans without usable angles or ranges": self.unusable_scans,
            "scans whose stamps do not rise": self.out_of_order,
            "scans without odometry around them": self.without_odometry,
            "odometry messages that are not finite or whose stamps do not rise": self.odometry,
            "odometry messages with places to which no robot can drive": self.absurd_odometry,
        }
        return [f"{count} {kind} were left out" for kind, count in given.items() if count]


class FirstReading(NamedTuple):
    """What the first reading of a bag yields."""

    keys: list[Key]
    """Of each scan, in the order of the file."""
    scans: TopicTimeline
    odometry: TopicTimeline
    as_written: bool
    """Whether to read in the order of the file."""
    track: OdometryTrack


class Pairing:
    """Reads a bag for its clocks and odometry, then for a delay of its scans, and then for them."""

    def __init__(
        self,
        bag: Bag,
        chosen: Chosen,
        layout: Layout,
        clock: str = "header",
        across: float | None = None,
    ) -> None:
        """Take stamps from the messages' headers, or (``log``) the times of recording.

        Args:
            bag: an open bag.
            chosen: its topics.
            layout: its frames.
            clock: one of ``CLOCKS``.
            across: the diagonal of the map [m], which lengths in another unit would not fit.
        """
        self._across = across
        self._bag, self._chosen, self._layout = bag, chosen, layout
        self._by_log = clock == "log"
        self.names = chosen.names
        """The topics that are read."""
        self.total = bag.count(chosen.names) + 2 * bag.count([chosen.scan])
        """Number of messages to read."""
        self.left_out = SkippedCounts()
        self.messages = 0
        """Number of messages read so far."""
        self.clocks: dict[str, tuple[float, float]] = {}
        """First and last stamp [s] of scans and of odometry."""
        self.remarks: list[str] = []
        """What was not as it should be, and what was done about it, in words."""

    def measurements(self) -> Iterator[Measurement]:
        """Yield all scans that can be used.

        Raises:
            BagError: the bag is damaged, or has lengths or angles in another unit.
        """
        first = self._first_reading()
        delay = self._delay(first)
        newest = -math.inf
        for scan, stamp in self._scans(first):
            if scan is None:
                self.left_out.unusable_scans += 1
            elif not stamp > newest:
                self.left_out.out_of_order += 1
            else:
                newest = stamp
                pose = first.track.at(stamp + delay)
                if pose is None:
                    self.left_out.without_odometry += 1
                else:
                    yield Measurement(pose, replace(scan, stamp=stamp + delay))

    def _scans(self, first: FirstReading) -> Iterator[tuple[Scan | None, float]]:
        """Yield each scan, None if it is unusable, and its stamp; nan if it has to be left out."""
        reader = ScanReader(self._layout.base_from_laser)
        times = first.scans
        stamps: defaultdict[Key, deque[float]] = defaultdict(deque)
        for index, stamp in zip(times.order.tolist(), times.stamps.tolist(), strict=True):
            stamps[first.keys[index]].append(stamp)
        for message in self._bag.messages([self._chosen.scan], as_written=first.as_written):
            self.messages += 1
            stamp = stamps[_key(message)].popleft()
            yield reader.scan(message.content, stamp), stamp

    def _delay(self, first: FirstReading) -> float:
        """Return how much later the scans were made than their stamps say [s], and remark it."""
        stamps = first.scans.stamps
        rising = stamps[~np.isnan(stamps)].tolist()
        wanted = pairs_to_compare(rising, first.track)
        kept: dict[int, Scan] = {}
        numbers = set(chain.from_iterable(wanted))
        usable = (scan for scan, stamp in self._scans(first) if not math.isnan(stamp))
        for number, scan in enumerate(usable):
            if number in numbers and scan is not None:
                kept[number] = scan
        pairs = [(kept[a], kept[b]) for a, b in wanted if a in kept and b in kept]
        delay = measured_delay(pairs, first.track)
        if delay is not None:
            late = "later" if delay.seconds > 0 else "earlier"
            self.remarks.append(
                f"scans fit odometry if they were made {abs(delay.seconds):.2f} s {late} than "
                f"their stamps say (standard deviation {delay.sd:.3f} s): they are used so"
            )
            return delay.seconds
        lag = first.scans.lag() - first.odometry.lag()
        if not self._by_log and LEAST_LAG_S <= abs(lag) <= JUMP_S:
            late = "later" if lag > 0 else "earlier"
            self.remarks.append(
                f"scans arrived {abs(lag):.2f} s {late} after their stamps than odometry did, and "
                "do not tell whether their stamps are wrong; --clock log takes the times of arrival"
            )
        return 0.0

    def _first_reading(self) -> FirstReading:
        """Read all stamps and all of odometry."""
        scans, odometry = Stream(), Stream()
        keys: list[Key] = []
        looks: list[UnitEvidence] = []
        poses: list[Pose2 | None] = []
        for message in self._bag.messages(self.names, as_written=True):
            self.messages += 1
            place, logged = self.messages, message.logged
            if message.topic == self._chosen.scan:
                keys.append(_key(message))
                if len(looks) < SAMPLES:
                    looks.append(UnitEvidence.of(message.content))
                content = zlib.crc32(np.asarray(message.content.ranges).tobytes())
                scans.add(place, logged, _stamp(message.content.header), content)
                continue
            for header, position, orientation in self._odometry(message):
                rigid = Rigid3.of(position, orientation)
                poses.append(None if rigid is None else rigid.planar())
                odometry.add(place, logged, _stamp(header), hash(poses[-1]))
        streams = {SCANS: scans, ODOMETRY: odometry}
        clocks = one_clock(streams, by_log=self._by_log)
        self.remarks += clocks.remarks
        for name, timeline in clocks.timelines.items():
            self._note_span(name, timeline)
        times, places = self._usable(clocks.timelines[ODOMETRY], poses)
        require_metres(looks, np.array(times), places, self._across)
        track = self._track(times, places)
        return FirstReading(
            keys, clocks.timelines[SCANS], clocks.timelines[ODOMETRY], clocks.as_written, track
        )

    def _odometry(self, message: BagMessage) -> Iterator[tuple[Any, Any, Any]]:
        """Yield header, position and orientation of each pose in a message."""
        if message.topic == self._chosen.odometry:
            pose = message.content.pose.pose
            yield message.content.header, pose.position, pose.orientation
            return
        for transform in message.content.transforms:
            frames = frame_name(transform.header.frame_id), frame_name(transform.child_frame_id)
            if frames == (self._layout.odom_frame, self._layout.base_frame):
                moved = transform.transform
                yield transform.header, moved.translation, moved.rotation

    def _usable(
        self, timeline: TopicTimeline, poses: list[Pose2 | None]
    ) -> tuple[list[float], list[Pose2]]:
        """Return the poses that are finite, with their rising stamps; the others are counted."""
        stamps: list[float] = []
        usable: list[Pose2] = []
        for index, stamp in zip(timeline.order.tolist(), timeline.stamps.tolist(), strict=True):
            pose = poses[index]
            if pose is not None and not math.isnan(stamp):
                stamps.append(stamp)
                usable.append(pose)
        self.left_out.odometry = len(poses) - len(usable)
        return stamps, usable

    def _track(self, stamps: list[float], poses: list[Pose2]) -> OdometryTrack:
        track = OdometryTrack.of(stamps, poses)
        self.left_out.absurd_odometry = track.absurd
        for stamp, metres in track.jumps:
            self.remarks.append(
                f"odometry was set elsewhere, {metres:.2f} m away, {stamp - stamps[0]:.1f} s after "
                "its beginning; it is followed as if it had not been"
            )
        return track

    def _note_span(self, name: str, times: TopicTimeline) -> None:
        usable = times.stamps[~np.isnan(times.stamps)]
        if len(usable):
            self.clocks[name] = float(usable[0]), float(usable[-1])


def _key(message: BagMessage) -> Key:
    return message.logged, _stamp(message.content.header)


def _stamp(header: Any) -> float:
    """Return the stamp of a header [s]; 0 if it has none."""
    stamp: float = header.stamp.sec + 1e-9 * header.stamp.nanosec
    return stamp
