"""A motor of the robot: its speed under load, and when it is set up."""

import numpy as np
import pytest

from benchmarks.hat.bricks import Bricks


@pytest.fixture
def bricks():
    made = Bricks()
    made.until(made.ready)
    made.wanted = np.radians([300.0, 300.0])
    made.run(0.6)
    return made


def test_with_too_much_load_it_does_what_it_can_and_does_not_race_when_the_load_is_gone(bricks):
    bricks.motor(1).load = 0.05
    assert bricks.run(2.0)[-500:, 2].min() > 100
    bricks.motor(1).load = 0.0
    bricks.run(0.4)
    assert bricks.run(0.4)[:, 2] == pytest.approx(300, rel=0.05)


def test_it_is_left_alone_while_another_is_missing(bricks, monkeypatch):
    """The list of the devices, which is asked for meanwhile, names the one that works as well."""
    bricks.emulated.unplug(0)
    bricks.run(1.0)
    sent, receive = bytearray(), bricks.emulated.receive
    monkeypatch.setattr(bricks.emulated, "receive", lambda data: (sent.extend(data), receive(data)))
    bricks.run(7.0)
    assert sent.count(b"list\r") >= 2
    assert b"port_plimit" not in sent, "set up again, it would lose its angle meanwhile"
