"""The engine without threads, faster than real time."""

import math
import threading

import numpy as np
import pytest

from app.assembly import Program, assemble
from app.config import Config
from app.engine.engine import MOST_COMMANDS
from app.engine.snapshot import Snapshot
from app.messages.commands import (
    DriveCommand,
    FigureEightCommand,
    PauseCommand,
    PingCommand,
    PlaceCommand,
    ResetCommand,
    ResumeCommand,
    ScatterCommand,
    SetParametersCommand,
    SetPoseCommand,
    ShowCommand,
    StopCommand,
    UpdateCommand,
)
from app.web.commands import MOST_WAITING, CommandError, check
from benchmarks.recovery import SEEDS, recover
from robot.driving.odometry import OdometrySettings
from robot.geometry import Pose2
from robot.interface import RobotError
from sim.floor_camera import CameraSettings
from sim.simulated import PERIOD

EIGHT = FigureEightCommand(type="figure_eight")


def kinematic(**settings):
    return assemble(Config(robot="kinematic", **settings))


def run(program: Program, seconds: float, *renewed) -> list[Snapshot]:
    """Step for a time, with commands renewed at each tick."""
    shown = []
    for _ in range(round(seconds / PERIOD)):
        for command in renewed:
            program.engine.commands.put(command)
        shown.append(program.engine.step())
    return shown


def drive(v=0.0, omega=0.0):
    return DriveCommand(type="drive", v=v, omega=omega)


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


def test_a_command_that_is_not_renewed_ends_after_half_a_second():
    program = kinematic()
    run(program, 1.0, drive(v=0.2))
    shown = run(program, 1.0)
    driven = [snapshot.stamp for snapshot in shown if snapshot.twist.v != 0]
    assert driven[-1] - (shown[0].stamp - PERIOD) <= 0.5 + 1e-9
    assert driven[-1] - shown[0].stamp > 0.4
    assert shown[-1].mode == "idle"
    assert shown[-1].truth == shown[-5].truth


@pytest.mark.parametrize("moving", [drive(v=0.2), EIGHT], ids=["drive", "figure eight"])
def test_stop_ends_everything_at_once(moving):
    program = kinematic()
    run(program, 0.6, moving)
    program.engine.commands.put(StopCommand(type="stop"))
    first = program.engine.step()
    assert first.twist.v == first.twist.omega == 0
    assert first.mode == "idle"
    assert run(program, 0.2)[-1].truth == first.truth


def test_the_figure_eight_comes_back_and_ends_without_renewal():
    program = kinematic()
    shown = run(program, 15.92, EIGHT)
    assert shown[-1].truth.distance_to(Pose2()) < 0.03
    assert max(snapshot.truth.y for snapshot in shown) == pytest.approx(0.38, abs=0.02)
    assert min(snapshot.truth.y for snapshot in shown) == pytest.approx(-0.38, abs=0.02)
    assert run(program, 0.7)[-1].mode == "idle"


def test_beyond_the_limits_it_is_limited_and_says_what_was_applied():
    last = run(kinematic(), 3.0, drive(v=9.0))[-1]
    assert last.twist.v == pytest.approx(Config().drive.max_velocity)


def test_the_estimate_never_sees_the_truth():
    """Wheels and pictures alike, but another truth: the same estimates."""
    told = []
    for lie in (Pose2(), Pose2(5, 5, 1)):
        program = kinematic()
        read = program.robot.read

        def lying(read=read, lie=lie):
            reading = read()
            return type(reading)(
                reading.stamp,
                reading.positions,
                reading.velocities,
                reading.frame,
                reading.battery_v,
                lie @ reading.truth,
            )

        program.robot.read = lying
        told.append([snapshot.pose for snapshot in run(program, 2.0, drive(v=0.1, omega=0.3))])
    assert told[0] == told[1]


def test_the_same_seed_is_the_same_run_bit_for_bit():
    def record(seed):
        program = assemble(Config(robot="sim", seed=seed))
        shown = run(program, 3.0, EIGHT)
        program.robot.close()
        return [(s.truth, s.odometry, s.pose, s.cloud.poses.tobytes()) for s in shown]

    first = record(7)
    assert record(7) == first
    assert record(8) != first


def test_place_moves_the_robot_and_tells_the_filter_nothing():
    program = kinematic()
    before = run(program, 2.0, drive(v=0.1, omega=0.5))[-1]
    program.engine.commands.put(PlaceCommand(type="place", x=0.2, y=-0.3, theta=1.0))
    after = run(program, 0.1)[-1]
    assert after.truth.distance_to(Pose2(0.2, -0.3, 1.0)) < 1e-9
    assert after.odometry.distance_to(after.truth) < 1e-9
    assert after.pose.distance_to(before.pose) < 0.02
    assert after.twist.v == 0


def test_set_pose_puts_the_cloud_where_it_is_told_as_wide_as_it_is_told():
    program = kinematic()
    run(program, 0.1)
    program.engine.commands.put(PauseCommand(type="pause"))
    told = SetPoseCommand(type="set_pose", x=0.1, y=0.2, theta=-1, sd_xy=0.03, sd_theta=0.1)
    program.engine.commands.put(told)
    poses = program.engine.step().cloud.poses
    assert poses.mean(axis=0) == pytest.approx([0.1, 0.2, -1], abs=0.01)
    assert poses.std(axis=0) == pytest.approx([0.03, 0.03, 0.1], rel=0.1)


def test_scatter_covers_the_field():
    program = kinematic()
    run(program, 0.1)
    program.engine.commands.put(PauseCommand(type="pause"))
    program.engine.commands.put(ScatterCommand(type="scatter"))
    poses = program.engine.step().cloud.poses
    assert poses[:, :2].min() < -0.4
    assert poses[:, :2].max() > 0.4
    assert np.histogram(poses[:, 2], bins=8, range=(-math.pi, math.pi))[0].min() > 0


def test_paused_the_cloud_follows_odometry_alone():
    program = kinematic()
    run(program, 1.0, drive(v=0.1))
    program.engine.commands.put(PauseCommand(type="pause"))
    paused = run(program, 1.0, drive(v=0.1))
    assert paused[-1].updates == paused[0].updates
    moved = paused[-1].pose.distance_to(paused[0].pose)
    assert moved == pytest.approx(paused[-1].truth.distance_to(paused[0].truth), abs=0.01)
    program.engine.commands.put(UpdateCommand(type="update"))
    assert run(program, 0.1)[-1].updates == paused[-1].updates + 1
    program.engine.commands.put(ResumeCommand(type="resume"))
    assert run(program, 1.0, drive(v=0.1))[-1].updates > paused[-1].updates + 10


def test_paused_the_estimate_follows_odometry_however_rarely_the_cloud_is_moved():
    program = kinematic()
    run(program, 0.4, drive(v=0.1))
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"update_min_d": 10})
    )
    program.engine.commands.put(PauseCommand(type="pause"))
    first = run(program, 0.1, drive(v=0.1))[-1]
    last = run(program, 2.0, drive(v=0.1))[-1]
    assert first.pose.distance_to(last.pose) == pytest.approx(0.2, abs=0.01)


def test_a_told_pose_is_not_moved_by_what_was_driven_before():
    program = kinematic()
    run(program, 0.4)
    program.engine.commands.put(
        SetParametersCommand(type="set_parameters", values={"update_min_d": 10})
    )
    told = run(program, 2.0, drive(v=0.1))[-1].truth
    program.engine.commands.put(StopCommand(type="stop"))
    program.engine.commands.put(
        SetPoseCommand(
            type="set_pose", x=told.x, y=told.y, theta=told.theta, sd_xy=0.001, sd_theta=0.001
        )
    )
    assert run(program, 0.2)[-1].pose.distance_to(told) < 0.01


def test_parameters_change_live_and_reset_brings_them_back():
    program = kinematic()
    values = {
        "filter": "particles",
        "min_particles": 123,
        "sigma_hit": 0.01,
        "laser_model_type": "beam",
    }
    program.engine.commands.put(SetParametersCommand(type="set_parameters", values=values))
    changed = run(program, 2.0, drive(v=0.1))[-1]
    assert changed.parameters.filter.min_particles == 123
    assert changed.parameters.sensor.laser_model_type == "beam"
    assert len(changed.cloud.weights) < 500  # one particle filter: none is there beside it
    program.engine.commands.put(ResetCommand(type="reset"))
    assert program.engine.step().parameters == Config().localization


def test_layers_are_switched():
    program = kinematic()
    program.engine.commands.put(ShowCommand(type="show", layer="rays", visible=False))
    assert "rays" not in program.engine.step().layers
    program.engine.commands.put(ShowCommand(type="show", layer="rays", visible=True))
    assert "rays" in program.engine.step().layers


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
    assert shown.problems == (program.engine.failure,)
    assert not np.any(program.robot.write(np.ones(2)))
    assert sum("engine stopped" in record.message for record in caplog.records) == 1


def test_a_camera_that_stalls_is_said_to():
    program = kinematic()
    run(program, 0.5)
    read = program.robot.read
    program.robot.read = lambda: _without_frame(read())
    shown = run(program, 1.0)
    assert shown[-1].problems == ("The camera sends no pictures.",)
    assert shown[-1].problem_count == 1
    program.robot.read = read
    assert run(program, 0.2)[-1].problems == ()


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
    program = kinematic(odometry=OdometrySettings(history=0.05), camera=CameraSettings(delay=0.5))
    last = run(program, 2.0, drive(v=0.1))[-1]
    assert any("too late" in problem for problem in last.problems)
    assert last.problem_count <= 2
    assert last.truth.x > 0.1


@pytest.mark.parametrize("frame_rate", [50, 60, 120])
def test_a_quick_camera_does_not_lag_behind(frame_rate):
    program = kinematic(camera=CameraSettings(frame_rate=frame_rate))
    last = run(program, 5.0, drive(v=0.05))[-1]
    assert last.problems == ()
    assert last.stamp - last.frame.stamp <= PERIOD + 0.03


def test_a_flood_of_commands_holds_no_tick_up():
    program = kinematic()
    for _ in range(10 * MOST_COMMANDS):
        program.engine.commands.put(drive(v=0.1))
    program.engine.step()
    assert program.engine.commands.qsize() == 9 * MOST_COMMANDS


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


@pytest.fixture(scope="module")
def recoveries():
    """Twelve robots with the default imperfections, told a wrong pose while they drive."""
    return [recover(seed) for seed in SEEDS]


def test_a_wrong_pose_is_recovered_from_within_four_seconds_in_twelve_of_twelve(recoveries):
    times = [one.seconds for one in recoveries]
    assert len(times) == 12
    assert max(times) <= 4.0, times


def test_tracking_is_within_three_millimetres(recoveries):
    assert np.mean([one.error for one in recoveries]) <= 0.003
    # The task is not trivial: dead reckoning alone is off by centimetres.
    assert np.mean([one.odometry_error for one in recoveries]) > 0.01
