"""Who gets a place at the server, and who makes room."""

import pytest

from app.page.room import RESERVE, SHARE, Room

HERE, THERE, ELSEWHERE = "127.0.0.1", "192.0.2.7", "192.0.2.8"


class Wire:
    """A connection that its server closes when its end is told."""

    _descriptors = iter(range(1000, 10**6))

    def __init__(self) -> None:
        self._descriptor = next(self._descriptors)
        self.ended = False

    def fileno(self) -> int:
        return -1 if self.ended else self._descriptor

    def shutdown(self, how: int) -> None:
        self.ended = True


def fill(room: Room, count: int, address: str = HERE, *, silent: bool) -> list[Wire]:
    wires = [Wire() for _ in range(count)]
    for wire in wires:
        assert room.admit(wire, address)
        room.set_silent(wire.fileno(), silent)
    return wires


def test_the_one_that_is_silent_for_longest_makes_room():
    room = Room(4)
    first, second, third, fourth = fill(room, 4, silent=True)
    room.set_silent(first.fileno(), False)
    room.set_silent(second.fileno(), False)
    room.set_silent(second.fileno(), True)  # answered just now
    assert room.admit(Wire(), HERE)
    assert [wire.ended for wire in (first, second, third, fourth)] == [False, False, True, False]
    assert room.admit(Wire(), HERE)
    assert (second.ended, fourth.ended) == (False, True)


def test_who_has_a_request_under_way_never_goes():
    room = Room(8)
    busy = fill(room, 8, silent=False)
    assert not room.admit(Wire(), HERE)
    assert not any(wire.ended for wire in busy)
    busy[3].ended = True
    assert room.admit(Wire(), HERE)


def test_an_address_elsewhere_gets_its_share_and_others_find_places():
    room = Room(8 * SHARE)
    busy = fill(room, 8, THERE, silent=False)
    assert not room.admit(Wire(), THERE)
    assert room.admit(Wire(), ELSEWHERE)
    assert room.admit(Wire(), HERE)
    room.set_silent(busy[2].fileno(), True)
    assert room.admit(Wire(), THERE)
    assert [wire.ended for wire in busy].index(True) == 2


@pytest.mark.parametrize("address", [HERE, "::1", "127.9.9.9", "::ffff:127.0.0.1"])
def test_this_computer_may_take_all_places(address):
    room = Room(40)
    fill(room, 40, address, silent=False)


def test_a_zone_in_an_address_is_no_mistake():
    assert Room(4).admit(Wire(), "fe80::1%eth0")


def test_pages_are_refused_before_the_last_places_are_taken():
    room = Room(10 * RESERVE)
    fill(room, 9 * RESERVE - 1, silent=False)
    fill(room, RESERVE + 1, silent=True)
    assert not room.crowded
    fill(room, 1, silent=False)
    assert room.crowded


def test_what_has_closed_makes_no_room():
    room = Room(4)
    gone, left = fill(room, 2, silent=True)
    gone.ended = True
    assert room.release()
    assert left.ended
    assert not room.release()


def test_what_has_closed_takes_no_place():
    room = Room(4)
    for wire in fill(room, 4, silent=False):
        wire.ended = True
    fill(room, 4, silent=False)
