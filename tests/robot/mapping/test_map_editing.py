"""Changes that people make to a finished map: an end moved, two strokes joined."""

import math

import numpy as np
import pytest

from robot.mapping.editing import with_joined, with_moved_end
from robot.mapping.ends import End
from robot.mapping.strokes import Stroke
from robot.mapping.tidying import TidyStrokes

TURNS = np.arange(12) * math.tau / 12
RING = Stroke(0.3 * np.column_stack([np.cos(TURNS), np.sin(TURNS)]), curved=True, closed=True)


def test_an_end_is_moved_and_its_corner_opens() -> None:
    two = TidyStrokes(
        (Stroke(np.array([[0.0, 0.0], [0.5, 0.0]])), Stroke(np.array([[0.5, 0.0], [0.5, 0.4]]))),
        (((0, True), (1, False)),),
        {},
    )
    moved = with_moved_end(two, (0, True), np.array([0.45, 0.05]))
    assert moved.strokes[0].nodes.tolist() == [[0.0, 0.0], [0.45, 0.05]]
    assert moved.strokes[1] is two.strokes[1]
    assert moved.corners == ()
    assert set(moved.ends) == {(0, True), (1, False)}
    with pytest.raises(ValueError, match="at least"):
        with_moved_end(two, (0, True), np.array([0.01, 0.0]))
    with pytest.raises(ValueError, match="ring"):
        with_moved_end(TidyStrokes((RING,), (), {}), (0, True), np.zeros(2))


@pytest.mark.parametrize("turned", [False, True])
def test_two_strokes_are_joined_where_their_ends_are_nearest(turned: bool) -> None:
    line, after = np.array([[0.0, 0.0], [0.4, 0.0]]), np.array([[0.5, 0.0], [0.9, 0.0]])
    corner = Stroke(np.array([[0.0, 0.0], [0.0, 0.3]]))
    each = (Stroke(line), corner, Stroke(after[::-1] if turned else after))
    free = End(np.array([0.9, 0.0]), np.array([1.0, 0.0]), 0.0, 0.0, math.nan)
    three = TidyStrokes(each, (((0, False), (1, False)),), {(2, not turned): free})
    whole = with_joined(three, 0, 2)
    assert len(whole.strokes) == 2
    assert whole.strokes[0].length == pytest.approx(0.9)
    assert whole.corners == (((0, False), (1, False)),)
    assert whole.ends == {(0, True): free}
    bent = with_joined(three, 1, 0)
    assert len(bent.strokes) == 2
    assert bent.strokes[0].curved
    assert bent.corners == ()
    with pytest.raises(ValueError, match="itself"):
        with_joined(three, 1, 1)
