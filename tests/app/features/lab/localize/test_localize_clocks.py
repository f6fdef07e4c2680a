"""Stamps that are wrong, and clocks that are set back while a bag is recorded."""

import math

import numpy as np
import pytest
from paired_bags import paired

from benchmarks.lasers.laser_bags import KINDS, LaserBag
from robot.geometry import Pose2

PERIOD = 0.1
COUNT = 60
BEGAN = 1.7e9
NAMES = {"ros1": "drive.bag", "sqlite3": "drive_sqlite3", "mcap": "drive_mcap"}


def write(path, stamp_of, logged_of=None, kind="mcap", count=COUNT):
    """A bag whose odometry is at x = the seconds of the drive, stamped as the function says."""
    with LaserBag(path, kind) as bag:
        for tick in range(count):
            seconds = PERIOD * tick
            logged = (logged_of or (lambda moment: BEGAN + moment))(seconds)
            bag.odometry(stamp_of("odometry", seconds), Pose2(seconds), logged=logged)
            stamp = stamp_of("scan", seconds)
            bag.scan(stamp, [1.0, 1.0], first=0.0, step=0.1, logged=logged + 1e-3)
    return path


def seconds_of(found):
    """When each scan was seen, by the odometry it is paired with."""
    return [round(each.odom_from_robot.x / PERIOD) for each in found]


def require_rising(found):
    assert (np.diff([each.scan.stamp for each in found]) > 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [0.0, 1.0, 5000.0, BEGAN + 3600, BEGAN + 3.15e7, 2e9, BEGAN - 5])
@pytest.mark.parametrize("place", [0, 1, 30, COUNT - 1])
@pytest.mark.parametrize("whose", ["scan", "odometry", "both"])
def test_one_wrong_stamp_leaves_out_that_message_alone(tmp_path, wrong, place, whose):
    def stamp(topic, seconds):
        hit = whose in (topic, "both") and round(seconds / PERIOD) == place
        return wrong if hit else BEGAN + seconds

    found, left_out, remarks = paired(write(tmp_path / "bag", stamp))
    if whose == "odometry" and place in (0, COUNT - 1):
        assert len(found) >= COUNT - 1  # nothing tells where the robot was at that end
    else:
        lost = [] if whose == "odometry" else [place]
        assert [tick for tick in range(COUNT) if tick not in seconds_of(found)] == lost
    assert left_out.out_of_order == (whose != "odometry")
    assert left_out.odometry == (whose != "scan")
    assert remarks == []
    require_rising(found)


def test_first_stamps_before_the_simulated_clock_begins_cost_themselves_alone(tmp_path):
    found, left_out, _ = paired(
        write(tmp_path / "bag", lambda _, seconds: 0.0 if seconds < 0.25 else 5000 + seconds)
    )
    assert seconds_of(found) == list(range(3, COUNT))
    assert (left_out.out_of_order, left_out.odometry) == (3, 3)


def test_a_stamp_a_few_seconds_ahead_costs_none_of_those_it_overtakes(tmp_path):
    found, left_out, _ = paired(
        write(tmp_path / "bag", lambda _, seconds: BEGAN + seconds + 3.0 * (seconds == 2.0))
    )
    assert seconds_of(found) == [tick for tick in range(COUNT) if tick != 20]
    assert left_out.out_of_order == 1


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.5, 1.0, 2.5, 30.0, 3600.0, 3.15e7])
@pytest.mark.parametrize("kind", KINDS)
def test_a_robots_clock_that_is_set_back_is_counted_on(tmp_path, size, kind):
    found, left_out, remarks = paired(
        write(
            tmp_path / NAMES[kind],
            lambda _, seconds: BEGAN + seconds - size * (seconds > 2.95),
            kind=kind,
        )
    )
    assert seconds_of(found) == list(range(COUNT))
    assert left_out.lines() == []
    assert len(remarks) == 1
    assert f"clock of scans and odometry was set back by {size:.1f} s, 3.0 s after" in remarks[0]
    require_rising(found)
    lasted = found[-1].scan.stamp - found[0].scan.stamp
    assert lasted == pytest.approx(PERIOD * (COUNT - 1), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.5, 1.0, 2.5, 3600.0, 3.15e7])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("same", [True, False])
def test_a_recorder_whose_clock_is_set_back_is_read_in_the_files_order(tmp_path, size, kind, same):
    """The robot's clock may be the same one, or that of another computer."""

    def logged(seconds):
        return BEGAN + seconds - size * (seconds > 2.95)

    path = write(
        tmp_path / NAMES[kind],
        lambda _, seconds: logged(seconds) if same else 5000 + seconds,
        logged,
        kind,
    )
    found, left_out, remarks = paired(path)
    assert seconds_of(found) == list(range(COUNT))
    assert left_out.lines() == []
    assert f"recorder's clock was set back by {size:.1f} s" in remarks[0]
    assert len(remarks) == 1 + same
    lasted = found[-1].scan.stamp - found[0].scan.stamp
    assert lasted == pytest.approx(PERIOD * (COUNT - 1), abs=0.01)


def test_a_recorders_clock_that_is_set_back_does_not_matter_by_the_log_either(tmp_path):
    path = write(
        tmp_path / "bag",
        lambda _, seconds: 0.5 * seconds,
        lambda seconds: BEGAN + seconds - 100 * (seconds > 2.95),
    )
    found, _, _ = paired(path, "log")
    assert seconds_of(found) == list(range(COUNT))


def test_two_steps_back_and_a_wrong_stamp_beside_one_are_told_apart(tmp_path):
    def stamp(topic, seconds):
        tick = round(seconds / PERIOD)
        if topic == "scan" and tick == 31:
            return BEGAN + 9e6
        return BEGAN + seconds - 50 * (tick >= 20) - 70 * (tick >= 40)

    found, left_out, remarks = paired(write(tmp_path / "bag", stamp))
    assert seconds_of(found) == [tick for tick in range(COUNT) if tick != 31]
    assert left_out.out_of_order == 1
    assert len(remarks) == 2


def test_a_file_with_one_topic_after_the_other_is_no_clock_that_is_set_back(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick in range(COUNT):
            bag.odometry(BEGAN + PERIOD * tick, Pose2(PERIOD * tick))
        for tick in range(COUNT):
            bag.scan(BEGAN + PERIOD * tick, [1.0, 1.0], first=0.0, step=0.1)
    found, left_out, remarks = paired(tmp_path / "bag")
    assert seconds_of(found) == list(range(COUNT))
    assert left_out.lines() == remarks == []


@pytest.mark.parametrize("odd", [BEGAN + 3.15e7, BEGAN - 3600, 1.0])
def test_one_odd_time_of_recording_does_not_matter(tmp_path, odd):
    path = write(
        tmp_path / "bag",
        lambda _, seconds: BEGAN + seconds,
        lambda seconds: odd if seconds == 3.0 else BEGAN + seconds,
    )
    found, left_out, remarks = paired(path)
    assert len(found) >= COUNT - 1
    assert left_out.out_of_order <= 1
    assert remarks == []


def test_messages_that_a_network_holds_back_are_no_step(tmp_path):
    """They come late, and then all at once."""
    path = write(
        tmp_path / "bag",
        lambda _, seconds: BEGAN + seconds,
        lambda seconds: BEGAN + (3.99 + 1e-3 * seconds if 1.0 < seconds < 4.0 else seconds),
    )
    found, left_out, remarks = paired(path)
    assert seconds_of(found) == list(range(COUNT))
    assert left_out.lines() == remarks == []


@pytest.mark.parametrize("rate", [0.01, 0.1, 5.0])
def test_a_simulation_may_run_slower_or_faster_than_time(tmp_path, rate):
    path = write(
        tmp_path / "bag",
        lambda _, seconds: 1.0 + seconds + 1e4 * (seconds == 2.0),
        lambda seconds: BEGAN + seconds / rate,
    )
    found, left_out, remarks = paired(path)
    assert seconds_of(found) == [tick for tick in range(COUNT) if tick != 20]
    assert (left_out.out_of_order, left_out.odometry) == (1, 1)
    assert remarks == []


def test_a_bag_that_was_played_again_is_followed_once(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick in range(2 * COUNT):
            stamp, logged = BEGAN + PERIOD * (tick % COUNT), BEGAN + PERIOD * tick
            bag.odometry(stamp, Pose2(math.sin(tick % COUNT)), logged=logged)
            ranges = [1.0, 1.0 + 0.01 * (tick % COUNT)]
            bag.scan(stamp, ranges, first=0.0, step=0.1, logged=logged)
    found, left_out, remarks = paired(tmp_path / "bag")
    assert len(found) == COUNT
    assert (left_out.out_of_order, left_out.odometry) == (COUNT, COUNT)
    assert sum("played again" in words for words in remarks) == 2
