"""What wheels tell of a robot, and what they only seem to tell."""

from __future__ import annotations

import numpy as np
import pytest

from robot.calibration.wheel_motion import BY_LEFT, BY_RIGHT, BY_SEPARATION, BY_SLIP, WheelMotion
from robot.description.unknowns import COUNT, NAMES
from robot.geometry import Array


def test_the_noise_of_wheels_that_go_straight_tells_no_separation() -> None:
    stamps = np.arange(100) / 10
    noise = np.random.default_rng(0).normal(0, 0.01, (len(stamps), 2))
    motion = WheelMotion(stamps, stamps, 4 * stamps[:, None] + noise, (0.028, 0.028), 0.12)
    straight = np.column_stack([0.112 * stamps, 0 * stamps, 0 * stamps])
    steps, by_wheels = motion.steps(np.zeros(COUNT), np.zeros((99, 2)))
    errors = straight[1:] - straight[:-1] - steps
    by_motion = by_wheels + motion.by_errors(np.zeros(COUNT), steps, errors)
    assert np.abs(by_wheels[:, 2, BY_SEPARATION]).max() > 1e-3
    assert np.abs(by_motion[:, 2, BY_SEPARATION]).max() < 1e-6


def circling(slip: Array) -> WheelMotion:
    """Wheels of a robot that drives a circle of always the same speed, and slip so much (k, 2)."""
    stamps = np.arange(len(slip)) / 10
    ways = np.array([0.3, 0.5])
    turned = ways + np.sqrt(np.mean(ways**2)) * slip
    angles = np.concatenate([np.zeros((1, 2)), np.cumsum(turned[:-1], axis=0)])
    return WheelMotion(stamps, stamps, angles, (0.028, 0.028), 0.12)


def test_slip_tells_no_separation() -> None:
    """Derivatives that change with slip would explain it, as the sizes of other wheels."""
    slip = np.random.default_rng(0).normal(0, 0.04, (100, 2))
    changes = [
        np.ptp(circling(slip).steps(np.zeros(COUNT), state[:-1])[1][:, 2, BY_SEPARATION])
        for state in (slip, 0 * slip)
    ]
    assert changes[0] < 0.1 * changes[1]


def test_slip_tells_no_larger_wheels() -> None:
    """Pictures of a drive whose wheels slip say as much of slip as of the wheels' size.

    Else the sum of the slip's squares is taken for wheels that are larger by 0.7 %.
    """
    rng = np.random.default_rng(0)
    slip, noise = rng.normal(0, 0.04, (100, 2)), rng.normal(0, 0.01, (100, 2))
    stamps = np.arange(100) / 10
    turned = 4 * stamps[:, None] + noise + np.cumsum(0.4 * slip, axis=0)
    motion = WheelMotion(stamps, stamps, turned, (0.028, 0.028), 0.12)
    steps, by_wheels = motion.steps(np.zeros(COUNT), slip[:-1])
    errors = np.array([0.0112, 0.0, 0.0]) - steps
    by_motion = by_wheels + motion.by_errors(np.zeros(COUNT), steps, errors)
    sizes = by_motion[:, 0, [BY_LEFT, BY_RIGHT]].sum(axis=1)
    assert sizes == pytest.approx(0.0112, rel=1e-3)
    assert -by_motion[:, 0, BY_SLIP].sum(axis=1) == pytest.approx(sizes, rel=0.02)


def test_the_robot_moves_at_a_picture_as_before_and_after_it() -> None:
    """A rolling shutter sees it: with the wheels as described it would tell where ahead is."""
    values = np.zeros(COUNT)
    values[[NAMES.index("left_radius"), NAMES.index("wheel_separation")]] = 0.05, -0.05
    slip = np.full((100, 2), [0.03, -0.02])
    motion = circling(0 * slip)
    arcs = motion.steps(values, slip[:-1])[0] / 0.1
    assert motion.twists(values, slip)[5:-5] == pytest.approx(arcs[5:-4, [0, 2]], rel=1e-3)
