"""Odometry's steady errors: what they do, how they are found, what they are of the wheels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_drives import drawn_runs, varied_steps

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_fit import fit_drive
from app.features.lab.model_fits.motions import STEP, DriveCorrection, MotionRun, chained
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive, WheelMultipliers
from robot.geometry import Twist2
from robot.localization.models.odometry_motion import DifferentialMotion

SPEC = RobotSpec.load()
TRACK = SPEC.track

factors = st.floats(0.95, 1.05)


def of_wheels(wheels, track):
    """What odometry needs that was reckoned without the multipliers; track [m] as described."""
    mean = (wheels.left_radius + wheels.right_radius) / 2
    curvature = (wheels.right_radius - wheels.left_radius) / (wheels.separation * track)
    return DriveCorrection(mean, mean / wheels.separation, curvature, track)


def on_wheels(radii, track):
    """The described robot on other wheels; only its joints are looked at."""
    joints = tuple(
        replace(joint, radius=radius, offset=math.copysign(track / 2, joint.offset))
        for joint, radius in zip(SPEC.joints, radii, strict=True)
    )
    return replace(SPEC, joints=joints)


@given(factors, factors, factors)
def test_multipliers_of_wheels_and_corrections_tell_the_same(left, right, separation):
    wheels = WheelMultipliers(left, right, separation)
    again = of_wheels(wheels, TRACK).wheel_multipliers()
    assert again.left_radius == pytest.approx(left)
    assert again.right_radius == pytest.approx(right)
    assert again.separation == pytest.approx(separation)


@given(factors, factors, factors, st.floats(-0.3, 0.3), st.floats(-2, 2))
def test_odometry_corrected_is_that_of_the_true_wheels(left, right, separation, v, omega):
    radii = [0.0, 0.0]
    radii[SPEC.axle[0]], radii[SPEC.axle[1]] = left * SPEC.wheel_radius, right * SPEC.wheel_radius
    true = on_wheels(radii, separation * TRACK)
    turned = DifferentialDrive(SPEC).wheels(Twist2(v, omega)) * 0.1
    believed = DifferentialDrive(SPEC).moved(turned).to_array()[None]
    correction = of_wheels(WheelMultipliers(left, right, separation), TRACK)
    assert correction.corrected(believed)[0] == pytest.approx(
        DifferentialDrive(true).moved(turned).to_array(), abs=1e-12
    )


def test_without_noise_the_planted_errors_are_found_exactly():
    steps = np.array([moved.to_array() for moved in varied_steps(120.0)])
    told = DriveCorrection(0.98, 1.03, -0.15, TRACK)
    stamps = STEP * np.arange(len(steps) + 1)
    run = MotionRun("exact", stamps, chained(steps), chained(told.corrected(steps)))
    found = fit_drive([run], track=TRACK).correction
    assert found.distance == pytest.approx(told.distance, abs=1e-6)
    assert found.turn == pytest.approx(told.turn, abs=1e-6)
    assert found.curvature == pytest.approx(told.curvature, abs=1e-6)


@pytest.mark.slow
def test_planted_errors_are_found_within_their_intervals():
    wheels = WheelMultipliers(1.01, 0.985, 1.02)
    told = of_wheels(wheels, TRACK)
    values = np.array([told.distance, told.turn, told.curvature])
    model = DifferentialMotion(0.02, 0.3, 0.05, 0.002)
    held = np.zeros(3)
    drives = drawn_runs(model, 8, 240.0, np.random.default_rng(4), correction=told)
    for run in drives:
        low, high = np.array(fit_drive([run], track=TRACK).intervals).T
        held += (low <= values) & (high >= values)
        assert (high - low < (0.1, 0.1, 0.8)).all()
    assert (held >= 7).all()
    together = fit_drive(drives, track=TRACK)
    found = together.correction.wheel_multipliers()
    assert found.left_radius == pytest.approx(1.01, abs=0.01)
    assert found.right_radius == pytest.approx(0.985, abs=0.01)
    assert found.separation == pytest.approx(1.02, abs=0.01)
    low, high = np.array(together.motion.intervals).T
    assert ((low <= (0.02, 0.3, 0.05, 0.002)) & (high >= (0.02, 0.3, 0.05, 0.002))).all()


def test_too_little_driving_is_refused():
    run = drawn_runs(DifferentialMotion(0, 0, 0, 0), 1, 3.0, np.random.default_rng(0))[0]
    with pytest.raises(FitError, match="at least 20 are needed, which is 100 s of driving"):
        fit_drive([run])
