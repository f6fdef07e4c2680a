"""The wall clock may be set at any time: only the date of what is shown and recorded follows it."""

import re
import time
from itertools import pairwise

import pytest
from engine_runs import EIGHT, drive, kinematic, run
from recordings import begin, recorder_of

from app.engine.drivers import Driver, Drivers
from app.features.recordings.files.mcap_reader import open_recording
from app.messages.driving_commands import DriveCommand
from app.settings.config import ROOT
from sim.simulated import PERIOD

WALL_CLOCK = re.compile(
    r"time\.time\(|time_ns\(\)|datetime\.now|date\.today|utcnow|CLOCK_REALTIME|record\.created"
)

READERS = {
    "app/features/lab/calibrate/calibrated_robot.py",  # the date of a profile
    "app/features/lab/mapping/command.py",
    "app/settings/profile_files.py",
    "app/features/calibration/outlet.py",
    "app/features/recordings/outlet.py",  # the names of recordings
    "app/features/recordings/library.py",  # the age of a file that is written
    "app/features/recordings/remote.py",
    "app/features/classroom/hub/authenticator.py",  # how old a sign-in is
    "app/features/classroom/hub/proxy_server.py",  # when a page was last used, for the hub
    "app/features/ros/incoming.py",  # the name of a map that has none
    "app/features/ros/source.py",  # ROS time
    "app/features/ros/rosbridge/bridge.py",
    "app/features/build_hat/robot_check.py",  # the age of a profile
    "robot/compiled_code.py",  # the age of files
}
"""Who needs the date; everything else counts time that passes."""

HOUR_NS = 3600 * 10**9


@pytest.fixture
def wall_clock(monkeypatch):
    """Sets the wall clock by so many hours."""
    real, realest = time.time_ns, time.time
    offset = [0]
    monkeypatch.setattr(time, "time_ns", lambda: real() + offset[0])
    monkeypatch.setattr(time, "time", lambda: realest() + offset[0] / 1e9)

    def put(hours):
        offset[0] = round(hours * HOUR_NS)

    return put


def test_nobody_else_reads_it():
    found = {
        str(path.relative_to(ROOT))
        for folder in ("app", "robot", "sim")
        for path in (ROOT / folder).rglob("*.py")
        if WALL_CLOCK.search(path.read_text(encoding="utf-8"))
    }
    assert found == READERS


@pytest.mark.slow
@pytest.mark.parametrize("hours", [-1, 1, -0.0002])
def test_no_log_time_of_a_recording_jumps_when_it_is_set(tmp_path, wall_clock, hours):
    program = kinematic()
    recorder, publisher = recorder_of(program, tmp_path)
    folder = begin(recorder, publisher)
    stamps = []
    for tick in range(100):
        if tick == 50:
            wall_clock(hours)
        shown = run(program, PERIOD, EIGHT)[-1]
        stamps.append(shown.stamp)
        publisher.tick(shown)
    recorder.close()
    reader = open_recording(folder)
    times = [message.log_time_ns for message in reader.messages({"/joint_states"})]
    assert len(times) == len(stamps)
    for before, after in pairwise(times):
        assert after - before == pytest.approx(PERIOD * 1e9, rel=0.01)
    assert reader.duration == pytest.approx(stamps[-1] - stamps[0], abs=0.05)


@pytest.mark.parametrize("hours", [-1, 1])
def test_a_drive_command_holds_as_long_when_it_is_set_meanwhile(wall_clock, hours):
    program = kinematic()
    run(program, 1.0, drive(v=0.2))
    wall_clock(hours)
    shown = run(program, 1.0)
    driven = [snapshot.stamp for snapshot in shown if snapshot.twist.v != 0]
    assert driven[-1] - (shown[0].stamp - PERIOD) == pytest.approx(0.28, abs=PERIOD + 1e-6)
    assert [one.stamp for one in shown] == sorted(one.stamp for one in shown)


@pytest.mark.parametrize("hours", [-1, 1])
def test_who_drives_does_not_change_when_it_is_set(wall_clock, hours):
    program = kinematic()
    drivers = Drivers.of(program)
    mine = Driver("mine")
    drivers.put(mine, DriveCommand(type="drive", v=0.1, omega=0))
    wall_clock(hours)
    assert drivers.state.driver is mine
