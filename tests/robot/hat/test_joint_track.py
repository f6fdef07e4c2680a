"""A motor's reports become one continuous angle, whatever the wire and the plug do to them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.hat.joint_track import FASTEST, JointTrack

DT = 0.01


def counted(angle: int) -> int:
    """As the motor counts: 32 bits."""
    return (angle + 2**31) % 2**32 - 2**31


def marked(angle: int, mark: int = 0) -> int:
    return (angle + mark + 180) % 360 - 180


def followed(angles, begin=0, mark=0):
    track = JointTrack()
    for i, angle in enumerate(angles):
        assert track.report(i * DT, counted(begin + angle), marked(begin + angle, mark))
    return track


steps = st.lists(st.integers(-14, 14), min_size=1, max_size=60)


begins = st.integers(-(2**31), 2**31 - 1) | st.integers(2**31 - 200, 2**31 - 1)


@given(steps, begins, st.integers(-180, 179))
def test_the_angle_goes_on_from_zero_over_the_wrap_of_32_bits(turns, begin, mark):
    angles = [0]
    for turn in turns:
        angles.append(angles[-1] + turn)
    assert followed(angles, begin, mark).angle == angles[-1]


@given(steps, begins)
def test_it_goes_on_where_it_was_after_a_plug_was_pulled(turns, begin):
    track = followed([0, 5, 10])
    track.begin_anew()
    angle = 0
    assert track.report(1.0, counted(begin), marked(begin))
    assert track.angle == 10
    for i, turn in enumerate(turns):
        angle += turn
        assert track.report(1.0 + (i + 1) * DT, counted(begin + angle), marked(begin + angle))
    assert track.angle == 10 + angle


@pytest.mark.parametrize(
    ("count", "absolute"),
    [(1, -179), (1234, 155), (12346, 15), (12345.5, 105), (math.inf, 0), (math.nan, 105)],
)
def test_a_lost_digit_is_not_believed(count, absolute):
    track = JointTrack()
    track.report(0.0, 12345, marked(12345))
    assert not track.report(DT, count, absolute)
    assert track.report(2 * DT, 12347, marked(12347))
    assert track.angle == 2


def test_a_count_without_its_highest_bit_is_not_believed():
    track = followed([0, 5, 10])
    assert not track.report(3 * DT, counted(10 + 2**31), marked(10))
    assert track.angle == 10


def test_a_digit_that_is_lost_now_and_then_is_never_believed():
    """A wheel that stands gives the same wrong number each time, but not in a row."""
    track = followed([12345])
    for i in range(1, 40):
        lost = i % 4 == 0
        assert track.report(i * DT, 1234 if lost else 12345, marked(12345)) is not lost


def test_reports_that_agree_with_each_other_are_believed_in_the_end_without_a_jump():
    track = followed([0, 4])
    later = [track.report(0.02 + i * DT, 9000 + i, marked(9000 + i)) for i in range(5)]
    assert later == [False] * 4 + [True]
    assert track.angle == 4
    assert track.report(0.08, 9006, marked(9006))
    assert track.angle == 6


def test_the_fastest_turn_is_believed_and_a_faster_one_is_not():
    fast = math.floor(FASTEST * DT)
    assert followed([0, fast, 2 * fast]).angle == 2 * fast
    track = followed([0])
    assert not track.report(DT, 3 * fast, marked(3 * fast))


@given(st.floats(0, 0.09))
def test_between_two_samples_it_is_interpolated(stamp):
    track = followed([10 * i for i in range(10)])
    assert track.at(stamp) == pytest.approx(1000 * stamp, abs=1e-6)


def test_before_and_after_what_is_known_it_is_the_end():
    track = followed([0, 10, 20])
    assert track.at(-1.0) == 0
    assert track.at(9.0) == 20
    assert JointTrack().at(0.0) == 0


def test_speed_is_the_mean_over_a_while():
    track = followed([5 * i for i in range(30)])
    assert track.speed(0.1) == pytest.approx(500)
    assert JointTrack().speed(0.1) == 0


def test_two_reports_of_one_moment_are_one_sample():
    track = followed([0, 3])
    assert track.report(DT, 4, 4)
    assert track.newest == (DT, 4)
    assert track.speed(0.1) == pytest.approx(400)
