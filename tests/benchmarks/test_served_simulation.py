"""How late ticks are said to be, where the loop went on, paused, or stood all the time."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.served_simulation import Ticks
from sim.simulated import PERIOD


class Every:
    """Ticks that were published, in the order in which they are taken."""

    def __init__(self, ticks):
        self.ticks = [None, *ticks, None]

    def get(self):
        return self.ticks.pop(0) if self.ticks else None


def delays(*late):
    """What is said of ticks that came so late [periods]."""
    ticks = [
        SimpleNamespace(stamp=PERIOD * number, published=PERIOD * (number + each))
        for number, each in late
    ]
    return Ticks(Every(ticks)).delays(0.2) / PERIOD


def test_the_most_punctual_tick_is_not_late():
    assert delays((1, 3.0), (2, 3.0), (3, 3.25)) == pytest.approx([0, 0, 0.25])


def test_ticks_that_were_due_while_the_loop_stood_count():
    assert sorted(delays((1, 0.0), (2, 0.0), (3, 4.0))) == pytest.approx([0, 0, 1, 2, 3, 4])


def test_a_loop_that_stood_all_the_time_is_as_late_as_that():
    assert np.ptp(delays()) == pytest.approx(0.2 / PERIOD - 2)
    assert delays().max() < 0.2 / PERIOD
