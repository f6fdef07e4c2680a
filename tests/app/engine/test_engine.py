"""The engine without threads, faster than real time."""

import math
import re
import threading
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from engine_runs import EIGHT, drive, kinematic, run

from app.engine.build import build_program
from app.engine.command_row import collected
from app.engine.commands import MOST_WAITING, check, table
from app.engine.driving import GAP_S
from app.engine.mailboxes.backlog import MOST_TAKEN
from app.messages.commands import (
    PauseCommand,
    PingCommand,
    SetCalibrationCommand,
    ShowCommand,
)
from app.messages.driving_commands import FigureEightCommand, StopCommand
from app.messages.message import CommandMessage
from app.settings.config import Config
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import NAMES, ROBOT
from robot.driving.odometry import OdometrySettings
from robot.errors import CommandError
from robot.geometry import Pose2, Twist2
from robot.interface import RobotError
from robot.localization.estimate import State
from robot.scan import Scan
from sim.floor_camera import CameraSettings
from sim.simulated import PERIOD, SimSettings


def test_it_stands_until_told_to_drive():
    shown = run(kinematic(), 0.5)
    assert {snapshot.mode for snapshot in shown} == {"idle"}
    assert shown[-1].truth == Pose2(0, 0, 0)


def test_a_drive_command_moves_it_forward():
    last = run(kinematic(), 2.0, drive(v=0.15))[-1]
    assert last.truth.x == pytest.approx(0.15 * 2, abs=0.04)
    assert abs(last.truth.y) < 1e-9
    assert last.twist.v == pytest.approx(0.15)
    assert last.mode == "drive"


def test_a_command_that_is_not_renewed_ends_after_its_time():
    program = kinematic()
    run(program, 1.0, drive(v=0.2))
    shown = run(program, 1.0)
    driven = [snapshot.stamp for snapshot in shown if snapshot.twist.v != 0]
    assert driven[-1] - (shown[0].stamp - PERIOD) <= 0.3 + 1e-9
    assert driven[-1] - shown[0].stamp > 0.25
    assert shown[-1].mode == "idle"
    assert shown[-1].truth == shown[-5].truth


def test_a_command_that_comes_while_the_robot_is_read_is_of_that_tick():
    program = build_program(Config(robot="kinematic"), lambda stamp: commands.put(drive(v=0.2)))
    commands = program.engine.commands
    assert program.engine.step().commands == (drive(v=0.2),)


@pytest.mark.parametrize("moving", [drive(v=0.2), EIGHT], ids=["drive", "figure eight"])
def test_stop_ends_everything_at_once(moving):
    program = kinematic()
    run(program, 0.6, moving)
    program.engine.commands.put(StopCommand(type="stop"))
    first = program.engine.step()
    assert first.twist.v == first.twist.omega == 0
    assert first.mode == "idle"
    assert run(program, 0.2)[-1].truth == first.truth


@pytest.mark.slow
def test_the_figure_eight_comes_back_and_ends_without_renewal():
    program = kinematic()
    shown = run(program, 15.92, EIGHT)
    assert shown[-1].truth.distance_to(Pose2()) < 0.03
    assert max(snapshot.truth.y for snapshot in shown) == pytest.approx(0.38, abs=0.02)
    assert min(snapshot.truth.y for snapshot in shown) == pytest.approx(-0.38, abs=0.02)
    assert run(program, 0.7)[-1].twist == Twist2()
    assert run(program, GAP_S)[-1].mode == "idle"


@pytest.mark.slow
def test_a_figure_eight_that_waited_for_its_renewal_goes_on_where_it_was():
    waiting, straight = kinematic(), kinematic()
    run(waiting, 5.0, EIGHT)
    halted = run(waiting, 1.5)[-1]
    assert (halted.mode, halted.twist) == ("figure_eight", Twist2())
    # Braking and starting again cost a few millimetres.
    end = run(waiting, 10.92, EIGHT)[-1].truth
    assert end.distance_to(run(straight, 15.92, EIGHT)[-1].truth) < 0.05
    begun = FigureEightCommand(type="figure_eight", start=True)
    waiting.engine.commands.put(begun)
    anew = run(waiting, 4.0, EIGHT)[-1].truth
    assert end.inverse().apply(np.array([[anew.x, anew.y]]))[0, 1] > 0.2, "the left circle first"


def test_beyond_the_limits_it_is_limited_and_says_what_was_applied():
    last = run(kinematic(), 3.0, drive(v=9.0))[-1]
    assert last.twist.v == pytest.approx(Config().drive.max_velocity)


@pytest.mark.slow
def test_the_same_seed_is_the_same_run_bit_for_bit():
    def record(seed):
        program = build_program(Config(robot="sim", seed=seed))
        shown = run(program, 3.0, EIGHT)
        program.robot.close()
        return [(s.truth, s.odometry, s.pose, s.filter.cloud.poses.tobytes()) for s in shown]

    first = record(7)
    assert record(7) == first
    assert record(8) != first


def test_layers_are_switched():
    program = kinematic()
    program.engine.commands.put(ShowCommand(type="show", layer="rays", visible=False))
    assert "rays" not in program.engine.step().layers
    program.engine.commands.put(ShowCommand(type="show", layer="rays", visible=True))
    assert "rays" in program.engine.step().layers


@pytest.mark.parametrize(
    ("positions", "words"),
    [([math.nan, 0.0], "positions are [nan, 0.0]"), ([0.0], "positions are [0.0]")],
)
def test_a_robot_that_says_no_numbers_ends_with_its_words(positions, words):
    program = kinematic()
    reading = program.robot.read()
    program.robot.read = lambda: replace(reading, positions=np.array(positions))
    with pytest.raises(RobotError, match=re.escape(f"{words}; valid are 2 finite numbers")):
        program.engine.step()


def test_a_robot_that_fails_is_closed_and_the_failure_is_shown(caplog):
    program = kinematic()
    last = run(program, 0.2)[-1]

    def unplugged():
        raise RobotError("the cable is out")

    program.robot.read = unplugged
    program.engine.run(threading.Event())
    shown = program.engine.latest.get()
    assert program.engine.failure == "The robot stopped: the cable is out"
    assert not shown.connected
    assert shown.stamp == last.stamp
    assert shown.problems.present == (program.engine.failure,)
    assert not np.any(program.robot.write(np.ones(2)))
    assert sum("engine stopped" in record.message for record in caplog.records) == 1


def test_of_a_robot_with_a_laser_alone_no_camera_is_missed():
    program = kinematic()
    read, bearings = program.robot.read, np.linspace(-1.0, 1.0, 9)

    def with_scan():
        reading = read()
        scan = Scan(reading.stamp, bearings, np.full(9, np.inf))
        return replace(reading, frame=None, scan=scan)

    program.robot.read = with_scan
    assert run(program, 1.0)[-1].problems.present == ()
    program.robot.read = lambda: _without_frame(read())
    assert run(program, 1.0)[-1].problems.present == ("The laser sends no scans.",)


def test_a_camera_that_stalls_is_said_to():
    program = kinematic()
    run(program, 0.5)
    read = program.robot.read
    program.robot.read = lambda: _without_frame(read())
    shown = run(program, 1.0)
    assert shown[-1].problems.present == ("The camera sends no pictures.",)
    assert shown[-1].problems.count == 1
    program.robot.read = read
    assert run(program, 0.2)[-1].problems.present == ()


def test_a_camera_that_stalls_for_long_stops_nothing():
    program = kinematic()
    last = run(program, 0.5)[-1]
    read = program.robot.read
    program.robot.read = lambda: _without_frame(read())
    shown = run(program, 5.0, drive(v=0.1))[-1]
    assert shown.truth.x > 0.4
    # The scan is still drawn from where it was made.
    assert shown.scan_pose == last.scan_pose


def test_a_picture_that_comes_too_late_is_told_and_not_used():
    sim = SimSettings(camera=CameraSettings(delay=0.5))
    program = kinematic(odometry=OdometrySettings(history=0.05), sim=sim)
    last = run(program, 2.0, drive(v=0.1))[-1]
    assert any("too late" in problem for problem in last.problems.present)
    assert last.problems.count <= 2
    assert last.truth.x > 0.1


def test_pictures_that_come_in_time_again_end_the_problem():
    program = kinematic(odometry=OdometrySettings(history=0.05))
    read, late = program.robot.read, 0.5

    def read_late():
        reading = read()
        frame = reading.frame
        return replace(reading, frame=frame and replace(frame, stamp=reading.stamp - late))

    program.robot.read = read_late
    assert any("too late" in problem for problem in run(program, 1.0)[-1].problems.present)
    late = 0.02
    assert run(program, 1.0)[-1].problems.present == ()


@pytest.mark.slow
@pytest.mark.parametrize("frame_rate", [50, 60, 120])
def test_a_quick_camera_does_not_lag_behind(frame_rate):
    program = kinematic(sim=SimSettings(camera=CameraSettings(frame_rate=frame_rate)))
    last = run(program, 5.0, drive(v=0.05))[-1]
    assert last.problems.present == ()
    assert last.stamp - last.frame.stamp <= PERIOD + 0.03


def test_a_flood_of_commands_holds_no_tick_up():
    program = kinematic()
    for _ in range(10 * MOST_TAKEN):
        program.engine.commands.put(drive(v=0.1))
    program.engine.step()
    assert len(program.engine.commands) == 9 * MOST_TAKEN


def test_what_cannot_be_done_any_more_is_refused():
    program = kinematic()
    program.engine.failure = "The robot stopped: the cable is out"
    with pytest.raises(CommandError, match="cable"):
        check(drive(v=0.1), program)
    check(PingCommand(type="ping"), program)


def test_only_stop_may_wait_behind_a_flood():
    program = kinematic()
    for _ in range(MOST_WAITING):
        program.engine.commands.put(drive())
    with pytest.raises(CommandError, match="wait"):
        check(drive(v=0.1), program)
    check(StopCommand(type="stop"), program)


def _without_frame(reading):
    return type(reading)(
        reading.stamp, reading.positions, reading.velocities, None, None, reading.truth
    )


@pytest.mark.slow
def test_a_pause_does_not_keep_what_was_claimed():
    """Odometry goes on, and errs: what is claimed grows with the way."""
    program = kinematic()
    run(program, 8.0, EIGHT)
    program.engine.commands.put(PauseCommand(type="pause"))
    shown = run(program, 40.0, EIGHT)
    radii = np.array([snapshot.integrity.radius for snapshot in shown[1:]])
    assert (np.diff(radii) > -1e-9).all()
    assert radii[-1] > 0.1
    for snapshot in shown:
        error = snapshot.pose.distance_to(snapshot.truth)
        assert error < snapshot.integrity.radius or snapshot.integrity.state is not State.CERTAIN


def test_every_command_has_a_row():
    ours = {each for each in CommandMessage.__subclasses__() if each.__module__.startswith("app.")}
    assert set(table()) == ours


def test_two_rows_for_a_command_are_refused():
    row = table()[StopCommand]
    with pytest.raises(ValueError, match="'stop'; valid is one"):
        collected((row, row))


def test_a_profile_s_delay_is_taken_off_a_picture_s_stamp(tmp_path):
    delayed = np.zeros(ROBOT)
    delayed[NAMES.index("picture_delay")] = 0.03
    spec = RobotSpec.load()
    profile = Profile(spec.name, datetime.now(UTC), "a test", delayed, np.full(ROBOT, 1e-3))
    (tmp_path / "profile.toml").write_text(profile.to_toml())
    shown = run(kinematic(profile=str(tmp_path / "profile.toml")), 1.0, drive(v=0.15))
    pictures = [
        (s.reading.frame.stamp, s.frame.stamp, s.filter.line_scan.scan.stamp)
        for s in shown
        if s.reading.frame
    ]
    assert {round(stamp - exposed, 6) for stamp, exposed, _ in pictures} == {0.03}
    assert all(exposed == scanned for _, exposed, scanned in pictures)


def test_a_calibration_changes_camera_wheels_and_delay() -> None:
    program = build_program(Config(robot="kinematic"))
    engine, spec = program.engine, program.robot.spec
    engine.step()
    rays = engine.localization.scanner.table.lines(3)
    values = {"camera_pitch": 0.02, "left_radius": 0.03, "picture_delay": 0.04}
    engine.commands.put(SetCalibrationCommand(type="set_calibration", values=values))
    engine.step()
    controls = engine.controls
    left = spec.axle[0]
    assert controls.odometry.drive.radii[left] == pytest.approx(1.03 * spec.joints[left].radius)
    assert controls.driving.kinematics is controls.odometry.drive
    assert controls.spec.picture_delay == pytest.approx(0.04)
    assert not np.allclose(engine.localization.scanner.table.lines(3), rays)
    fit = {"converged": False, "residual": 0.5, "overrun": ["camera_z +4.2"]}
    engine.commands.put(
        SetCalibrationCommand(type="set_calibration", values=dict.fromkeys(values, 0.0), fit=fit)
    )
    engine.step()
    assert Profile.of(controls.spec).fit == fit
    np.testing.assert_allclose(engine.localization.scanner.table.lines(3), rays)
    assert controls.odometry.drive.radii[left] == pytest.approx(spec.joints[left].radius)


@pytest.mark.parametrize("values", [{"camera_picth": 0.0}, {"left_radius": 0.9}])
def test_an_impossible_calibration_is_refused(values: dict[str, float]) -> None:
    program = build_program(Config(robot="kinematic"))
    with pytest.raises(CommandError, match="valid"):
        check(SetCalibrationCommand(type="set_calibration", values=values), program)
