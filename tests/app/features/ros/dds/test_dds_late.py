"""A participant that comes long after the robot finds it."""

from __future__ import annotations

import pytest
from dds_rig import Rig, own_domain
from ros_messages import topic

from benchmarks.topics.fastdds import Peer, missing

pytestmark = [pytest.mark.skipif(missing() is not None, reason=str(missing())), pytest.mark.slow]

PRUNED_S = 35.0
"""Cyclone DDS forgets an address at which nobody answered for half a minute, unless told not to."""


def test_who_comes_after_half_a_minute_finds_the_robot() -> None:
    """Twice: the second one after another has left."""
    with Rig(own_domain()) as rig:
        rig.until(lambda snapshot: snapshot.stamp > PRUNED_S, seconds=PRUNED_S + 5)
        for _ in range(2):
            with Peer(rig.domain) as late:
                late.read("rt/scan", topic("scan").type, reliable=False)
                late.data("rt/scan")
