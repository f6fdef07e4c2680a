"""Strokes that bend: over gaps, at their ends, and when the map is moved as a whole."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mappings import WIDTH, mapped

from robot.geometry import Array, Pose2
from robot.mapping.ends import BEND_OFF, BEYOND, RaysOnFloor, straight_ahead
from robot.mapping.joining import is_tape_between
from robot.mapping.map_adjustment import moved_to_start
from robot.mapping.strokes import Stroke, Strokes


def arc(radius: float, angle: float, count: int) -> Array:
    turns = np.linspace(0, angle, count)
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])


CURVE = Stroke(arc(0.5, 1.0, 7), curved=True)
LINE = Stroke(np.array([[0.1, -0.4], [0.7, -0.2]]))


@pytest.mark.slow
def test_a_map_is_moved_as_a_whole_to_where_the_robot_began() -> None:
    drawn, _ = mapped("square", 60100)
    start = np.array([0.3, -0.2, 2.0])
    solution, strokes = moved_to_start(drawn.solution, drawn.measured, start)
    before, after = drawn.solution.state.poses, solution.state.poses
    np.testing.assert_allclose(after[0], start)
    motion = Pose2(*start) @ Pose2(*before[0]).inverse()
    np.testing.assert_allclose(after[:, :2], motion.apply(before[:, :2]))
    np.testing.assert_allclose(solution.misses.ends, motion.apply(drawn.solution.misses.ends))
    for old, new in zip(drawn.measured.each, strokes.each, strict=True):
        np.testing.assert_allclose(new.points, motion.apply(old.points), atol=1e-9)


def test_what_a_map_says_of_bends_is_nothing_of_lines_that_move_as_a_whole() -> None:
    strokes = Strokes.of([CURVE, LINE, Stroke(arc(0.2, 1.0, 5), curved=True)], WIDTH)
    ramps = [3.0 + 0.5 * np.arange(len(stroke.nodes)) for stroke in strokes.traced]
    np.testing.assert_allclose(strokes.bends @ np.concatenate(ramps), 0.0, atol=1e-12)
    assert strokes.bends.shape == (5 + 3, 7 + 2 + 5)


def test_tape_is_looked_for_straight_ahead_as_far_as_it_is_straight() -> None:
    round_end = Stroke(arc(0.2, 1.5, 12), curved=True)
    for last in (False, True):
        place, outward = round_end.end(last)
        ahead = place + straight_ahead(round_end, last) * outward
        assert math.hypot(*ahead) - 0.2 == pytest.approx(BEND_OFF, rel=0.15)
        assert straight_ahead(LINE, last) == BEYOND


@given(st.floats(0.15, 0.5), st.floats(0.06, 0.11), st.booleans())
def test_a_bend_goes_on_over_a_gap(radius: float, length: float, bare: bool) -> None:
    """Rays across the gap of a ring saw its tape, or bare floor; then it is not closed."""
    turn = length / radius
    (place, out), (other, back) = (
        (radius * np.array([math.cos(a), math.sin(a)]), s * np.array([-math.sin(a), math.cos(a)]))
        for a, s in ((0.0, 1.0), (turn, -1.0))
    )
    ways = np.linspace(0.05, 0.95, 60) * turn
    along = np.column_stack([np.cos(ways), np.sin(ways)])
    nothing = np.full_like(along, np.nan)
    near, far = ((radius + side * WIDTH / 2) * along for side in (1, -1))
    rays = RaysOnFloor(
        (radius + 0.1) * along,
        (radius - 0.1) * along,
        *(4 * [nothing] if bare else [near, far, near, far]),
        np.arange(60),
    )
    assert is_tape_between(place, out, other, back, WIDTH, rays) is not bare
