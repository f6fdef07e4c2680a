"""What is believed while an engine runs, and what commands do to it; faster than real time."""

import math

import numpy as np
import pytest
from engine_runs import drive, kinematic, run

from app.features.lab.workers import LocalWorkers
from app.messages.commands import (
    PauseCommand,
    PlaceCommand,
    ResetCommand,
    ResumeCommand,
    ScatterCommand,
    SetParametersCommand,
    SetPoseCommand,
    UpdateCommand,
)
from app.messages.driving_commands import StopCommand
from app.settings.config import Config
from benchmarks.recovery import SEEDS, recover
from robot.geometry import Pose2

pytestmark = pytest.mark.slow

PAUSE = PauseCommand(type="pause")
SELDOM = SetParametersCommand(type="set_parameters", values={"update_min_d": 10})
"""Measurements, and steps of the cloud, are 10 m apart."""


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
    program.engine.commands.put(PAUSE)
    told = SetPoseCommand(type="set_pose", x=0.1, y=0.2, theta=-1, sd_xy=0.03, sd_theta=0.1)
    program.engine.commands.put(told)
    poses = program.engine.step().filter.cloud.poses
    assert poses.mean(axis=0) == pytest.approx([0.1, 0.2, -1], abs=0.01)
    assert poses.std(axis=0) == pytest.approx([0.03, 0.03, 0.1], rel=0.1)


def test_another_kind_of_filter_does_not_go_on_saying_what_the_one_before_said():
    program = kinematic()
    to_particles, to_hypotheses = (
        SetParametersCommand(type="set_parameters", values={"filter": name})
        for name in ("particles", "hypotheses")
    )
    program.engine.commands.put(to_particles)
    program.engine.commands.put(ScatterCommand(type="scatter"))
    before = run(program, 0.1)[-1]
    assert before.estimate is not None
    program.engine.commands.put(to_hypotheses)
    for shown in run(program, 0.3):
        assert shown.estimate is None or shown.estimate.stamp > before.estimate.stamp


def test_scatter_covers_the_field():
    program = kinematic()
    run(program, 0.1)
    program.engine.commands.put(PAUSE)
    program.engine.commands.put(ScatterCommand(type="scatter"))
    poses = program.engine.step().filter.cloud.poses
    assert poses[:, :2].min() < -0.4
    assert poses[:, :2].max() > 0.4
    assert np.histogram(poses[:, 2], bins=8, range=(-math.pi, math.pi))[0].min() > 0


def test_paused_the_cloud_follows_odometry_alone():
    program = kinematic()
    run(program, 1.0, drive(v=0.1))
    program.engine.commands.put(PAUSE)
    paused = run(program, 1.0, drive(v=0.1))
    assert paused[-1].filter.updates == paused[0].filter.updates
    moved = paused[-1].pose.distance_to(paused[0].pose)
    assert moved == pytest.approx(paused[-1].truth.distance_to(paused[0].truth), abs=0.01)
    program.engine.commands.put(UpdateCommand(type="update"))
    assert run(program, 0.1)[-1].filter.updates == paused[-1].filter.updates + 1
    program.engine.commands.put(ResumeCommand(type="resume"))
    assert run(program, 1.0, drive(v=0.1))[-1].filter.updates > paused[-1].filter.updates + 10


def test_paused_the_estimate_follows_odometry_however_rarely_the_cloud_is_moved():
    program = kinematic()
    run(program, 0.4, drive(v=0.1))
    program.engine.commands.put(SELDOM)
    program.engine.commands.put(PAUSE)
    first = run(program, 0.1, drive(v=0.1))[-1]
    last = run(program, 2.0, drive(v=0.1))[-1]
    assert first.pose.distance_to(last.pose) == pytest.approx(0.2, abs=0.01)


def test_a_told_pose_is_not_moved_by_what_was_driven_before():
    program = kinematic()
    run(program, 0.4)
    program.engine.commands.put(SELDOM)
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
    assert changed.filter.parameters.filter.min_particles == 123
    assert changed.filter.parameters.sensor.laser_model_type == "beam"
    assert len(changed.filter.cloud.weights) < 500  # one particle filter: none is there beside it
    program.engine.commands.put(ResetCommand(type="reset"))
    assert program.engine.step().filter.parameters == Config().localization


@pytest.fixture(scope="module")
def recoveries():
    """Twelve robots with the default imperfections, told a wrong pose while they drive."""
    crew = LocalWorkers(2)
    done = dict(crew.each(recover, SEEDS))
    crew.close()
    return [done[seed] for seed in SEEDS]


def test_a_wrong_pose_is_recovered_from_within_four_seconds_in_twelve_of_twelve(recoveries):
    times = [one.seconds for one in recoveries]
    assert len(times) == 12
    assert max(times) <= 4.0, times


def test_tracking_is_within_three_millimetres(recoveries):
    assert np.mean([one.error for one in recoveries]) <= 0.003
    # The task is not trivial: dead reckoning alone is off by centimetres.
    assert np.mean([one.odometry_error for one in recoveries]) > 0.01
