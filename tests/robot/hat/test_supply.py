"""When the supply of a Build HAT lets motors be driven."""

import pytest

from robot.hat.supply import HYSTERESIS_V, Supply

LOW_V = 6.0


@pytest.fixture
def supply():
    return Supply(LOW_V)


def is_low(supply, *volts):
    """Whether it complains after these reports [V]."""
    for reported in volts:
        supply.take_voltage(reported)
    return bool(supply.complaints(0.0))


def test_a_dip_that_is_reported_once_is_a_start_and_no_low_supply(supply):
    for _ in range(3):
        assert not is_low(supply, 8.0, 5.8)


def test_low_twice_in_a_row_it_is_low_until_it_is_well_above_the_limit(supply):
    assert is_low(supply, 8.0, 5.8, 5.9)
    assert is_low(supply, LOW_V + HYSTERESIS_V - 0.01)
    assert not is_low(supply, LOW_V + HYSTERESIS_V)


@pytest.mark.parametrize("garbled", [0.0, 2.9, 20.1, 83.0])
def test_a_voltage_that_no_board_runs_on_is_not_believed(supply, garbled):
    assert not is_low(supply, 8.0, garbled, garbled)
    assert supply.volts == 8.0
