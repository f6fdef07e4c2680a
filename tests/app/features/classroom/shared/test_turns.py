"""Whose turn it is: one drives, all others wait in the order in which they came."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.features.classroom.shared.turns import TurnQueue

NAMES = ["ada", "bo", "cy", "di"]
ACTIONS = st.one_of(
    st.tuples(st.sampled_from(["join", "leave", "hand_to"]), st.sampled_from(NAMES)),
    st.tuples(st.just("skip")),
    st.tuples(st.just("wait"), st.floats(0, 200)),
    st.tuples(st.just("end"), st.booleans()),
)


class _Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def queue(turn_s: float = 60.0) -> tuple[TurnQueue, _Clock]:
    clock = _Clock()
    return TurnQueue(turn_s, clock), clock


def test_each_drives_for_a_turn_in_the_order_in_which_they_came():
    turns, clock = queue()
    for name in NAMES[:3]:
        turns.join(name)
    seen = []
    for _ in range(3):
        seen.append(turns.driver)
        clock.now += 59.0
        turns.look()
        assert turns.driver == seen[-1]
        clock.now += 1.0
        turns.look()
    assert seen == NAMES[:3]
    assert turns.driver == "cy", "nobody waits, so the last goes on"
    turns.join("ada")
    assert turns.driver == "ada", "whose turn is over makes room at once"


def test_the_teacher_hands_over_skips_and_ends():
    turns, clock = queue()
    for name in NAMES[:3]:
        turns.join(name)
    clock.now = 30.0
    turns.hand_to("cy")
    assert (turns.driver, turns.waiting, turns.seconds_left) == ("cy", ["ada", "bo"], 60.0)
    turns.skip()
    assert (turns.driver, turns.waiting) == ("ada", ["bo"])
    turns.end(ended=True)
    turns.join("di")
    turns.hand_to("di")
    assert (turns.driver, turns.waiting) == (None, [])
    turns.end(ended=False)
    turns.join("di")
    assert turns.driver == "di"


@given(st.lists(ACTIONS, max_size=30))
def test_nobody_is_in_it_twice_and_nobody_waits_for_an_empty_seat(actions):
    turns, clock = queue()
    for name, *values in actions:
        if name == "wait":
            clock.now += values[0]
            turns.look()
        elif name == "end":
            turns.end(ended=values[0])
        else:
            getattr(turns, name)(*values)
        present = [turns.driver, *turns.waiting] if turns.driver else turns.waiting
        assert len(present) == len(set(present))
        assert turns.driver is not None or not turns.waiting
        assert not (turns.ended and present)
        assert 0 <= turns.seconds_left <= 60.0
