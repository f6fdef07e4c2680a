"""As many moments are chosen as wanted, whichever come."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine.mailboxes.rhythm import EARLY_S, Rhythm


def chosen(moments: list[float], rate: float) -> list[float]:
    rhythm, found = Rhythm(), []
    for now in moments:
        if rhythm.wait(now) <= 0:
            rhythm.choose(now, rate)
            found.append(now)
    return found


@pytest.mark.parametrize("rate", [1.0, 10.0, 25.0, 30.0, 50.0])
def test_of_fifty_moments_a_second_so_many_are_chosen(rate):
    moments = [0.02 * tick + 0.001 * (tick % 3) for tick in range(1000)]
    assert len(chosen(moments, rate)) == pytest.approx(20 * rate, abs=2)


def test_of_endless_rate_each_is_chosen():
    moments = [0.0, 0.001, 0.002, 5.0]
    assert chosen(moments, math.inf) == moments


@given(st.lists(st.floats(0, 0.5), max_size=60), st.floats(1, 60))
def test_no_more_are_chosen_than_the_rate_and_after_a_pause_none_waits(gaps, rate):
    moments = [sum(gaps[:count]) for count in range(len(gaps))]
    found = chosen(moments, rate)
    for begin in range(len(found)):
        for end in range(begin, len(found)):
            most = (found[end] - found[begin] + 2 * EARLY_S) * rate + 2
            assert end - begin + 1 <= most
    for last, now in itertools.pairwise(moments):
        if now - last > 1 / rate:
            assert now in found
