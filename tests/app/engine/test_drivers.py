"""One client drives at a time, and a stop holds for all."""

from __future__ import annotations

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine.drivers import RETURN_S, SILENCE, Driver, Drivers
from app.engine.mailboxes.backlog import Backlog
from app.messages.commands import Command, ScatterCommand
from app.messages.driving_commands import DriveCommand, FigureEightCommand, StopCommand, TakeCommand
from robot.errors import CommandError

DRIVE = DriveCommand(type="drive", v=0.1, omega=0.0)
STOP = StopCommand(type="stop")
TAKE = TakeCommand(type="take")
EIGHT = FigureEightCommand(type="figure_eight")
TIMEOUT = 0.5
RENEWAL = 0.05


class Floor:
    """Two people at one robot."""

    def __init__(self, *, stopped: bool = False) -> None:
        self.stamp = 0.0
        self.queue: Backlog[Command] = Backlog()
        self.drivers = Drivers(self.queue, TIMEOUT, lambda: self.stamp, stopped=stopped)
        self.ann, self.bob = Driver("Ann"), Driver("Bob")

    def try_to(self, driver: Driver, command: Command) -> bool:
        """Whether a command is taken."""
        try:
            self.drivers.put(driver, command)
        except CommandError:
            return False
        return True

    def hold(self, driver: Driver, seconds: float) -> list[bool]:
        """Renew a drive command, as a held key does; return which renewals are taken."""
        taken = []
        for _ in range(round(seconds / RENEWAL)):
            taken.append(self.try_to(driver, DRIVE))
            self.stamp += RENEWAL
        return taken


@pytest.fixture
def floor() -> Floor:
    return Floor()


class Broken:
    """A program that takes no command: what of it is asked for that."""

    failure = "the camera is gone"
    commands = ()

    @property
    def engine(self) -> Broken:
        return self


def test_who_does_not_drive_is_told_that_before_what_else_is_wrong(floor: Floor) -> None:
    floor.drivers.put(floor.ann, DRIVE)
    for command in (DRIVE, EIGHT):
        with pytest.raises(CommandError, match="Ann drives; take over"):
            floor.drivers.check(floor.bob, command, Broken())
        with pytest.raises(CommandError, match="the camera is gone"):
            floor.drivers.check(floor.ann, command, Broken())
    with pytest.raises(CommandError, match="the camera is gone"):
        floor.drivers.check(floor.bob, ScatterCommand(type="scatter"), Broken())


def test_the_first_who_drives_has_the_drive_and_others_are_told(floor: Floor) -> None:
    assert all(floor.hold(floor.ann, 0.3))
    with pytest.raises(CommandError, match="Ann drives; take over"):
        floor.drivers.put(floor.bob, DRIVE)
    with pytest.raises(CommandError, match="Ann drives"):
        floor.drivers.put(floor.bob, EIGHT)
    assert floor.drivers.state.driver is floor.ann
    assert floor.drivers.put(floor.bob, ScatterCommand(type="scatter")) is None


def test_who_lets_go_for_a_second_has_the_drive_no_more(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.stamp += SILENCE
    assert floor.drivers.state.driver is None
    assert floor.try_to(floor.bob, DRIVE)
    assert not floor.try_to(floor.ann, DRIVE)


def test_a_stop_from_before_a_change_of_program_holds_against_a_key_held_since() -> None:
    """The new program knows no gesture from before: who drives soon may have driven then."""
    floor = Floor(stopped=True)
    floor.stamp = 0.5 * RETURN_S
    assert not any(floor.hold(floor.ann, 2 * SILENCE))
    floor.stamp += SILENCE  # Ann has let go.
    assert all(floor.hold(floor.ann, 0.3))
    later = Floor(stopped=True)
    later.stamp = RETURN_S
    assert all(later.hold(later.bob, 0.3))


def test_a_stop_holds_against_who_goes_on_holding_a_key(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    assert floor.try_to(floor.bob, STOP)
    assert floor.drivers.state == floor.drivers.state.__class__(None, True)
    assert not any(floor.hold(floor.ann, 10.0))
    with pytest.raises(CommandError, match="a stop holds"):
        floor.drivers.put(floor.ann, DRIVE)


def test_a_stop_ends_with_a_new_gesture(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.drivers.put(floor.bob, STOP)
    assert not floor.try_to(floor.bob, DRIVE)  # a renewal on its way
    floor.stamp += SILENCE
    assert floor.try_to(floor.ann, DRIVE)
    assert not floor.drivers.state.stopped


def test_who_begins_to_drive_after_a_stop_waits_a_second_and_need_not_let_go(floor: Floor) -> None:
    floor.drivers.put(floor.ann, STOP)
    floor.stamp += 0.2
    taken = floor.hold(floor.bob, 2.0)
    assert taken.index(True) * RENEWAL == pytest.approx(SILENCE - 0.2, abs=RENEWAL)
    assert all(taken[taken.index(True) :])


def test_who_takes_the_drive_ends_a_stop_at_once(floor: Floor) -> None:
    floor.drivers.put(floor.ann, STOP)
    floor.drivers.put(floor.ann, TAKE)
    assert all(floor.hold(floor.ann, 0.2))


def test_the_drive_can_be_taken_from_who_has_it_and_the_robot_stops_between(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.queue.take()
    floor.drivers.put(floor.bob, TAKE)
    assert floor.queue.take() == (STOP,)
    assert not any(floor.hold(floor.ann, 0.5))
    assert floor.try_to(floor.bob, DRIVE)


def test_a_held_key_does_not_keep_another_from_driving_after_a_stop(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.drivers.put(floor.bob, STOP)
    floor.hold(floor.ann, 1.1)
    assert floor.try_to(floor.bob, DRIVE)
    assert not any(floor.hold(floor.ann, 0.5))


def test_who_leaves_while_driving_stops_the_robot_and_nobody_else_does(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.try_to(floor.bob, DRIVE)
    floor.queue.take()
    floor.drivers.leave(floor.bob)
    assert floor.queue.take() == ()
    floor.drivers.leave(floor.ann)
    assert floor.queue.take() == (STOP,)
    assert not floor.drivers.state.stopped
    assert floor.try_to(floor.bob, DRIVE)


@pytest.mark.parametrize("commands", [(EIGHT,), (TAKE, EIGHT), (EIGHT, TAKE)])
def test_a_programme_waits_for_whoever_renewed_it(floor: Floor, commands) -> None:
    for command in commands:
        floor.drivers.put(floor.ann, command)
    floor.queue.take()
    floor.drivers.leave(floor.ann)
    assert floor.queue.take() == (), "the robot stands when nobody renews it"
    assert floor.try_to(floor.bob, DRIVE)


def test_taking_the_drive_again_while_driving_by_hand_still_stops_at_leaving(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.drivers.put(floor.ann, TAKE)
    floor.queue.take()
    floor.drivers.leave(floor.ann)
    assert floor.queue.take() == (STOP,)


def test_of_one_person_s_pages_the_one_drives_that_began_last(floor: Floor) -> None:
    lesson = Driver("the lesson", floor.ann.person)
    assert all(floor.hold(floor.ann, 0.3))
    assert floor.try_to(lesson, EIGHT)
    with pytest.raises(CommandError, match="another page of yours drives"):
        floor.drivers.put(floor.ann, DRIVE)
    assert floor.drivers.state.driver is lesson
    floor.drivers.put(floor.ann, TAKE)
    assert floor.try_to(floor.ann, DRIVE)
    assert not floor.try_to(lesson, EIGHT)
    with pytest.raises(CommandError, match="Ann drives"):
        floor.drivers.put(floor.bob, DRIVE)


def test_no_drive_command_overtakes_a_stop_of_another_thread(
    floor: Floor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once a stop is in the queue, no command follows that was taken before it."""
    put = floor.queue.put
    stop = threading.Thread(target=floor.drivers.put, args=(floor.bob, STOP))

    def put_late(command: Command) -> None:
        if command is DRIVE:
            stop.start()
            stop.join(0.2)  # it has to wait until the drive command is in the queue
        put(command)

    monkeypatch.setattr(floor.queue, "put", put_late)
    floor.drivers.put(floor.ann, DRIVE)
    stop.join(10)
    assert floor.queue.take() == (DRIVE, STOP)


def test_an_unreadable_command_stops_the_robot_of_its_sender_alone(floor: Floor) -> None:
    floor.hold(floor.ann, 0.3)
    floor.queue.take()
    floor.drivers.refuse(floor.bob)
    assert floor.queue.take() == ()
    floor.drivers.refuse(floor.ann)
    assert floor.queue.take() == (STOP,)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["ann", "bob"]), st.sampled_from([DRIVE, STOP, TAKE]), st.floats(0, 1.5)
        )
    )
)
def test_never_do_two_drive_within_a_second_without_a_take_or_stop_between(steps) -> None:
    floor = Floor()
    last: tuple[Driver, float] | None = None
    for name, command, pause in steps:
        driver = getattr(floor, name)
        taken = floor.try_to(driver, command)
        if command is not DRIVE:
            assert taken
            last = None
        elif taken:
            assert last is None or last[0] is driver or floor.stamp - last[1] >= SILENCE
            last = driver, floor.stamp
        floor.stamp += pause
