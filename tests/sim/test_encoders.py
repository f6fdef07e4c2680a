"""Encoders count whole degrees, and wheels slip."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.description.spec import RobotSpec
from sim.encoders import VELOCITY_SPAN, Encoders
from sim.imperfections import Imperfections

SPEC = RobotSpec.load()
DEGREE = math.radians(1)
COUNTING = Imperfections(slip_sd=0)


def encoders(imperfections: Imperfections, seed: int = 1) -> Encoders:
    return Encoders(SPEC, imperfections, np.random.default_rng(seed))


@given(st.lists(st.floats(-1000, 1000), min_size=1, max_size=20))
def test_without_imperfections_positions_pass_unchanged(angles: list[float]) -> None:
    exact = encoders(Imperfections.none())
    for tick, angle in enumerate(angles):
        positions, _ = exact.read(np.array([angle, -angle]), tick * 0.02)
        np.testing.assert_array_equal(positions, [angle, -angle])


@given(st.floats(-1000, 1000), st.integers(0, 2**32))
def test_positions_are_whole_degrees_and_never_more_than_one_off(angle: float, seed: int) -> None:
    positions, _ = encoders(COUNTING, seed).read(np.array([angle, angle]), 0.0)
    np.testing.assert_allclose(positions / DEGREE, np.round(positions / DEGREE), atol=1e-6)
    assert (np.abs(positions - angle) <= DEGREE * (1 + 1e-9)).all()


def test_counting_does_not_add_up_errors() -> None:
    counting = encoders(COUNTING)
    for tick in range(5000):
        true = np.array([0.1, -0.07]) * tick * 0.02
        positions, _ = counting.read(true, tick * 0.02)
    assert (np.abs(positions - true) <= DEGREE).all()


def test_the_velocity_is_the_turn_over_its_span() -> None:
    exact = encoders(Imperfections.none())
    for tick in range(20):
        _, velocities = exact.read(np.array([5.0, -3.0]) * tick * 0.02, tick * 0.02)
    np.testing.assert_allclose(velocities, [5, -3])


def test_the_velocity_of_the_first_reading_is_zero() -> None:
    _, velocities = encoders(COUNTING).read(np.array([3.0, 3.0]), 0.0)
    np.testing.assert_array_equal(velocities, [0, 0])


def test_counted_velocities_waver_by_no_more_than_one_count_over_the_span() -> None:
    counting = encoders(COUNTING)
    seen = []
    for tick in range(200):
        _, velocities = counting.read(np.array([5.36, 5.36]) * tick * 0.02, tick * 0.02)
        seen.append(velocities[0])
    assert np.abs(np.array(seen[10:]) - 5.36).max() <= DEGREE / VELOCITY_SPAN * (1 + 1e-9)


def test_the_velocity_of_a_wheel_that_stopped_is_zero_after_the_span() -> None:
    counting = encoders(COUNTING)
    for tick in range(50):
        _, velocities = counting.read(np.full(2, min(tick, 20) * 0.1), tick * 0.02)
        if tick >= 20 + round(VELOCITY_SPAN / 0.02):
            np.testing.assert_array_equal(velocities, [0, 0])


def slips(imperfections: Imperfections, ticks: int, seed: int = 1) -> np.ndarray:
    """Relative slip (ticks, 2) over each reading of wheels that turn evenly."""
    slipping = encoders(imperfections, seed)
    reported = np.array(
        [slipping.read(np.full(2, tick * 0.1), tick * 0.02)[0] for tick in range(ticks + 1)]
    )
    return np.diff(reported, axis=0) / 0.1 - 1


def test_slip_has_its_spread_and_its_memory() -> None:
    slip = slips(Imperfections(slip_sd=0.02, slip_time=0.5, encoder_step=0), 40_000)
    assert slip.std() == pytest.approx(0.02, rel=0.1)
    assert abs(slip.mean()) < 0.002
    lag = 25  # 0.5 s: what is left of it is 1/e
    alike = np.mean(slip[:-lag] * slip[lag:]) / np.mean(slip**2)
    assert alike == pytest.approx(math.exp(-1), abs=0.1)
    assert abs(np.corrcoef(slip.T)[0, 1]) < 0.1, "the wheels slip apart"


def test_slip_does_not_depend_on_how_often_the_encoders_are_read() -> None:
    spreads = []
    for period in (0.01, 0.1):
        ends = []
        for seed in range(200):
            slipping = encoders(Imperfections(encoder_step=0, slip_time=0.3), seed)
            for tick in range(round(2 / period) + 1):
                stamp = tick * period
                positions, _ = slipping.read(np.full(2, 5 * stamp), stamp)
            ends.append(positions[0] - 10)
        spreads.append(np.std(ends))
    assert spreads[0] == pytest.approx(spreads[1], rel=0.2)


def test_a_wheel_that_stands_does_not_slip() -> None:
    slipping = encoders(Imperfections(slip_sd=0.5, encoder_step=0))
    for tick in range(100):
        positions, velocities = slipping.read(np.array([2.0, 2.0]), tick * 0.02)
    np.testing.assert_array_equal(positions, [2, 2])
    np.testing.assert_array_equal(velocities, [0, 0])


def test_the_same_seed_reads_the_same_and_another_does_not() -> None:
    one, same, other = (slips(Imperfections(), 50, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()


@pytest.mark.parametrize("stamp", [0.02, 0.0])
def test_a_stamp_that_does_not_rise_is_refused(stamp: float) -> None:
    counting = encoders(COUNTING)
    counting.read(np.zeros(2), 0.02)
    with pytest.raises(ValueError, match="follows"):
        counting.read(np.zeros(2), stamp)


def test_what_it_hands_out_is_not_its_own() -> None:
    exact, true = encoders(Imperfections.none()), np.array([1.0, 2.0])
    positions, _ = exact.read(true, 0.0)
    positions[:] = 9
    true[:] = 9
    _, velocities = exact.read(np.array([1.0, 2.0]), 0.02)
    np.testing.assert_array_equal(velocities, [0, 0])
