"""What waits for one slow reader."""

from app.engine.mailboxes.outbox import Outbox


def waiting(outbox) -> list:
    return list(iter(outbox.take, None))


def test_of_each_name_the_newest_waits():
    outbox = Outbox()
    for name, value in [("odom", 1), ("scan", 2), ("odom", 3)]:
        outbox.put(name, value)
    assert waiting(outbox) == [3, 2]
    assert waiting(outbox) == []


def test_names_take_turns_and_each_keeps_its_order():
    outbox = Outbox()
    for value in (1, 2, 3):
        outbox.put("odom", value, most=2)
    outbox.put("scan", 4)
    assert waiting(outbox) == [2, 4, 3]


def test_when_it_is_full_older_values_of_a_name_go_but_never_the_newest():
    outbox = Outbox(most_size=10)
    for value in (1, 2, 3):
        outbox.put("map", value, most=9, size=4)
    outbox.put("picture", 4, size=99)
    assert waiting(outbox) == [2, 4, 3]
    outbox.put("map", 5, most=9, size=10)
    outbox.put("map", 6, most=9, size=10)
    assert waiting(outbox) == [6]


def test_a_name_that_is_dropped_leaves_its_room():
    outbox = Outbox(most_size=10)
    outbox.put("map", 1, most=9, size=9)
    outbox.drop("map")
    outbox.drop("nothing")
    outbox.put("scan", 2, most=9, size=5)
    outbox.put("scan", 3, most=9, size=5)
    assert waiting(outbox) == [2, 3]
