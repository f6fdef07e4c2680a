"""Scans of pictures that come late are put where they were taken; the monitor hears how sure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from floor_scans import LEFT, PERIOD, drive

from app.features.plausibility.motion_checks import MotionChecks
from robot.geometry import interpolate
from robot.scan import Scan

CIRCLES = [LEFT] * 200
TRACK = 0.12


class Advised(SimpleNamespace):
    """A monitor that believes, or not, that wheels slip."""

    def __init__(self, *, slips: bool = False) -> None:
        super().__init__(slips=slips, may_be_late=not slips, forgotten=0, doubted=0)
        self.of_clearing = np.zeros((3, 3))

    def forget(self) -> None:
        self.forgotten += 1

    def doubt_lateness(self) -> None:
        self.doubted += 1


def followed(late: Any, monitor: Advised) -> list[tuple[float, float, float]]:
    """Return stamps, how far each scan is off where it was taken, and what the monitor hears [m].

    Args:
        late: by how much the picture of a stamp is stamped later [s].
        monitor: is advised.
    """
    checks: Any = MotionChecks(TRACK)
    poses, last, rows = [pose for _, pose in drive(CIRCLES)], -np.inf, []
    for scan, pose in drive(CIRCLES):
        stamp = scan.stamp + late(scan.stamp)
        if stamp <= last:
            continue  # it comes out of order
        last, place = stamp, min(stamp / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        stamped = Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan)
        checks.add(stamped, odometry)
        seen = checks.on_time(stamped)
        monitor.of_clearing = np.zeros((3, 3))
        checks.advise(monitor)
        off = (odometry @ seen.robot_from_scan).distance_to(pose @ scan.robot_from_scan)
        rows.append((stamp, off, float(np.sqrt(monitor.of_clearing[0, 0]))))
    return rows


def test_scans_of_pictures_that_come_later_all_at_once_are_put_where_they_were_taken() -> None:
    monitor = Advised()
    rows = followed(lambda stamp: 0.09 if stamp > 5.6 else 0.0, monitor)
    (before, heard), (waits, hears), (after, _) = (
        np.array([row[1:] for row in rows if first < row[0] < until]).T
        for first, until in ((1.0, 5.6), (5.7, 6.0), (6.5, 13.0))
    )
    assert before.max() < 1e-12
    assert heard.max() == 0.0
    assert waits.max() > 0.012
    assert np.all(waits < 2 * hears)  # what is not yet confirmed is told as unsure
    assert after.max() < 0.002
    assert monitor.doubted > 0


@pytest.mark.parametrize("at_first", [0.0, 0.09])
def test_a_second_time_of_late_pictures_is_reckoned_with_like_the_first(at_first: float) -> None:
    """Pictures that are late at first seem to come early after that, which is no debt."""

    def late(stamp: float) -> float:
        if stamp < 1.8:
            return at_first
        return 0.09 if 5.6 < stamp < 7.5 or stamp > 9.5 else 0.0

    rows = np.array(followed(late, Advised()))
    for first, until in ((6.5, 7.4), (8.6, 9.4), (10.6, 13.0)):
        times = (first < rows[:, 0]) & (rows[:, 0] < until)
        assert rows[times, 1].max() < 0.004, first


def test_of_pictures_that_come_by_turns_most_is_put_right() -> None:
    rng, monitor = np.random.default_rng(3), Advised()
    rows = np.array(followed(lambda _: float(rng.uniform(0.0, 0.066)), monitor))
    late, known = rows[rows[:, 0] < 2.0], rows[rows[:, 0] > 9.0]
    assert np.sqrt(np.mean(known[:, 1] ** 2)) < 0.6 * np.sqrt(np.mean(late[:, 1] ** 2))
    assert np.mean(known[:, 1] < 2 * known[:, 2]) > 0.9
    assert monitor.forgotten >= 1


@pytest.mark.parametrize("late", [0.03, 0.09])
def test_while_wheels_slip_no_picture_is_put_elsewhere(late: float) -> None:
    rng, monitor = np.random.default_rng(3), Advised(slips=True)
    rows = followed(lambda stamp: late if stamp > 5.6 else 0.0, monitor)
    rows += followed(lambda _: float(rng.uniform(0.0, 0.066)), monitor)
    assert max(heard for _, _, heard in rows) == 0.0
    assert monitor.forgotten == 0
    assert max(off for stamp, off, _ in rows if stamp > 7.0) > 0.004


def test_pictures_that_come_earlier_than_the_first_are_not_put_elsewhere() -> None:
    """Wheels that slip for a moment look just so."""
    rows = followed(lambda stamp: 0.0 if stamp > 5.6 else 0.09, Advised())
    assert np.allclose([off for stamp, off, _ in rows if 1.0 < stamp < 5.6], 0.0135, atol=0.002)
    assert np.allclose([off for stamp, off, _ in rows if 7.0 < stamp < 13.0], 0.0, atol=1e-9)


def test_a_punctual_scan_stays_the_same_object() -> None:
    checks = MotionChecks(TRACK)
    for scan, pose in drive([LEFT] * 30):
        checks.add(scan, pose)
        assert checks.on_time(scan) is scan


def test_a_robot_that_is_put_elsewhere_begins_with_punctual_pictures() -> None:
    """A calibrated robot was 5 mm off for good: its wheels had looked like late pictures before."""
    checks: Any = MotionChecks(TRACK)
    monitor: Any = Advised()
    poses = [pose for _, pose in drive(CIRCLES)]
    for number, (scan, _) in enumerate(drive(CIRCLES)):
        late = 0.09 if number > 84 else 0.0
        place = min(number + late / PERIOD, len(poses) - 1.001)
        odometry = interpolate(poses[int(place)], poses[int(place) + 1], place % 1)
        stamp = scan.stamp + late
        checks.add(Scan(stamp, scan.bearings, scan.ranges, scan.robot_from_scan), odometry)
        checks.advise(monitor)
    assert checks.on_time(scan) is not scan
    checks.forget_lateness()
    checks.add(scan, poses[-1])
    assert checks.on_time(scan) is scan
