"""A place that was doubted is claimed again only after a search of what was seen since."""

from __future__ import annotations

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, Drive

from robot.geometry import Pose2
from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.filter import Setup
from robot.localization.hypotheses.candidate_weights import EQUAL, FoundPlace, has_rival
from robot.localization.hypotheses.confirmation import Confirmation
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters
from robot.localization.particles.particle_filter import ParticleFilter

P = HypothesisParameters(map_scans=6)
SETUP = Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)
COVARIANCE = np.diag(np.square([0.001, 0.001, 0.003]))
TURNED = (Pose2(0, 0, np.pi),)


def track_at(pose: Pose2) -> Track:
    one = ParticleFilter.of(SETUP, np.random.default_rng(0))
    one.set_pose(pose, COVARIANCE)
    return Track(one, 0.0)


def filled(local: LocalMap, scans: int) -> LocalMap:
    drive = Drive(Pose2())
    for _ in range(scans):
        local.move(Pose2(0.01, 0, 0))
        assert local.add(drive.scan())
    return local


def place(pose: Pose2, log_evidence: float) -> FoundPlace:
    return FoundPlace(pose, COVARIANCE, -9.0, log_evidence)


def test_a_place_that_was_never_doubted_needs_no_search() -> None:
    one = Confirmation()
    assert one.confirmed and not one.is_due(100, filled(LocalMap.of(P), 6))


@pytest.mark.parametrize("rival", [True, False])
def test_a_given_place_is_as_given_until_a_search_finds_no_rival(rival: bool) -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 3)
    assert one.standing is Standing.GIVEN
    one.begin(3, local)
    one.end(3, rival=rival)
    assert one.standing is (Standing.GIVEN if rival else Standing.CONFIRMED)


def test_a_given_place_that_is_doubted_is_as_any_other() -> None:
    one = Confirmation()
    one.doubt(3)
    one.end(3, rival=False)
    assert one.standing is Standing.UNCONFIRMED


def test_a_place_that_replaced_another_needs_a_further_short_map_for_each_time() -> None:
    one = Confirmation()
    places = [track_at(Pose2()), track_at(Pose2(0.5, 0, 0))]
    assert [one.follow(places[i % 2], 1.0, P) for i in range(3)] == [False, True, True]
    one.doubt(10)
    one.lose([])  # The place was doubtful before, so this is no carried robot.
    local = filled(LocalMap.of(P), 28)
    assert not one.is_due(10 + 3 * P.map_scans - 1, local)
    assert one.is_due(10 + 3 * P.map_scans, local)
    one.begin(28, local)
    one.end(28, rival=False)
    assert one.confirmed
    one.doubt(40)
    assert one.is_due(40 + P.map_scans, local)


@pytest.mark.parametrize(
    ("weight", "another", "confirmed"),
    [(1.0, False, True), (1.0, True, False), (ONLY_PLACE, False, False)],
)
def test_only_who_leads_for_long_is_confirmed(
    weight: float, another: bool, confirmed: bool
) -> None:
    one, track = Confirmation(), track_at(Pose2())
    one.note(track, weight, another)
    assert track.confirmed == confirmed
    one.lose([track])
    assert not track.confirmed
    one.doubt(10)
    one.note(track, 1.0, another=False)
    assert not track.confirmed


def test_only_a_search_of_scans_since_the_doubt_gives_it_back() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 10)
    one.doubt(10)
    assert not local.whole and not one.is_due(15, local)
    one.begin(15, local)
    one.end(15, rival=False)
    assert not one.confirmed
    assert one.is_due(16, local)
    one.begin(16, local)
    assert not one.is_due(16, local)
    one.end(17, rival=False)
    assert one.confirmed


def test_a_doubt_during_the_search_takes_it_back() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    one.doubt(11)
    one.end(12, rival=False)
    assert not one.confirmed


def test_a_rival_puts_it_off_by_a_short_map_and_once() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    one.end(11, rival=True)
    assert not one.confirmed
    assert not one.is_due(16, local) and one.is_due(17, local)
    one.begin(17, local)
    one.end(18, rival=True)
    assert one.confirmed


@pytest.mark.parametrize("change", ["lost", "another leads", "nothing was told"])
def test_a_rival_puts_off_a_new_place_until_it_is_told_apart(change: str) -> None:
    one, local = Confirmation(given=change != "nothing was told"), filled(LocalMap.of(P), 10)
    one.follow(track_at(Pose2()), 1.0, P)
    one.doubt(0)
    if change == "lost":
        one.lose([])
    if change == "another leads":
        assert one.follow(track_at(Pose2(0.3, 0, 0)), 1.0, P)
    for scans in (10, 17, 24):
        one.begin(scans, local)
        one.end(scans, rival=True)
        assert not one.confirmed
    one.begin(31, local)
    one.end(31, rival=False)
    assert one.confirmed


def test_a_map_that_began_anew_is_enough_as_soon_as_it_is_full() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 6)
    local.begin_anew(2)
    one.doubt(8)
    assert not one.is_due(9, filled(local, 3))
    assert one.is_due(10, filled(local, 1))


def test_it_notices_when_another_place_leads() -> None:
    one = Confirmation()
    first, beside, other = (track_at(Pose2(x, 0, 0)) for x in (0.0, 0.002, 0.3))
    assert not one.follow(first, 1.0, P)
    assert not one.follow(beside, 1.0, P)
    assert not one.follow(other, ONLY_PLACE, P)
    assert one.follow(other, 1.0, P)
    one.lose([])
    assert not one.follow(first, 1.0, P)


@pytest.mark.parametrize(
    ("places", "rival"),
    [
        ([], False),
        ([place(Pose2(0.5, 0, 0), EQUAL - 0.1)], False),
        ([place(Pose2(0.5, 0, 0), EQUAL + 0.1)], True),
        ([place(Pose2(-0.3, 0, np.pi), 0.0)], False),
        ([place(Pose2(-0.3, 0, np.pi), 0.0), place(Pose2(0.5, 0, 0), 0.0)], True),
    ],
    ids=["none", "fits worse", "fits as well", "its image", "its image and another"],
)
def test_a_rival_fits_as_well_and_is_no_image(places: list[FoundPlace], rival: bool) -> None:
    assert has_rival([track_at(Pose2(0.3, 0, 0))], places, (), TURNED, P) == rival
