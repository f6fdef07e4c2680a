"""A place that was doubted is claimed again only after a search of what was seen since."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, Drive

from robot.geometry import Pose2
from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.filter import Setup
from robot.localization.hypotheses.candidate_weights import EQUAL, FoundPlace, rival_poses
from robot.localization.hypotheses.confirmation import Confirmation
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters
from robot.localization.particles.particle_filter import ParticleFilter

P = HypothesisParameters(map_scans=6)
SETUP = Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)
COVARIANCE = np.diag(np.square([0.001, 0.001, 0.003]))
RIVAL, OTHER = Pose2(0.5, 0, 0), Pose2(0, 0.5, 1)
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


def end(one: Confirmation, scans: int, *, rival: bool) -> None:
    rivals = [RIVAL] if rival else []
    one.end(scans, rivals, rivals)


def test_a_place_that_was_never_doubted_needs_no_search() -> None:
    one = Confirmation()
    assert one.confirmed and not one.is_due(100, filled(LocalMap.of(P), 6))


@pytest.mark.parametrize("rival", [True, False])
def test_a_given_place_is_as_given_until_a_search_finds_no_rival(rival: bool) -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 3)
    assert one.standing is Standing.GIVEN
    one.begin(3, local)
    end(one, 3, rival=rival)
    assert one.standing is (Standing.GIVEN if rival else Standing.CONFIRMED)


def test_a_given_place_that_is_doubted_is_as_any_other() -> None:
    one = Confirmation()
    one.doubt(3)
    end(one, 3, rival=False)
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
    end(one, 28, rival=False)
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
    end(one, 15, rival=False)
    assert not one.confirmed
    assert one.is_due(16, local)
    one.begin(16, local)
    assert not one.is_due(16, local)
    end(one, 17, rival=False)
    assert one.confirmed


def test_a_doubt_during_the_search_takes_it_back() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    one.doubt(11)
    end(one, 12, rival=False)
    assert not one.confirmed


def test_a_rival_puts_it_off_by_a_short_map_and_once() -> None:
    one, local = Confirmation(), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    end(one, 11, rival=True)
    assert not one.confirmed
    assert not one.is_due(16, local) and one.is_due(17, local)
    one.begin(17, local)
    end(one, 18, rival=True)
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
        end(one, scans, rival=True)
        assert not one.confirmed
    one.begin(31, local)
    end(one, 31, rival=False)
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


def doubted() -> tuple[Confirmation, LocalMap]:
    """Return a place that is new, of which one search has refuted all others but a rival."""
    one, local = Confirmation(given=False), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    one.end(11, [RIVAL], [RIVAL])
    assert not one.confirmed
    return one, local


def test_what_a_search_has_refuted_is_no_rival_of_the_next() -> None:
    one, _ = doubted()
    one.end(13, [OTHER], [OTHER])
    assert one.confirmed


@pytest.mark.parametrize("error", [Pose2(), Pose2(0.03, 0.02, 0.1)])
def test_a_rival_goes_along_with_the_robot(error: Pose2) -> None:
    one, _ = doubted()
    moved = Pose2(0.2, 0.01, 0.5)
    one.move(moved)
    one.end(13, [RIVAL @ moved @ error, OTHER], [RIVAL @ moved @ error, OTHER])
    assert not one.confirmed
    one.end(15, [OTHER], [OTHER])
    assert one.confirmed


def test_a_search_that_may_have_missed_places_refutes_none() -> None:
    one, local = Confirmation(given=False), filled(LocalMap.of(P), 10)
    one.doubt(0)
    one.begin(10, local)
    one.end(11, [RIVAL], None)
    one.end(13, [OTHER], [OTHER])
    assert not one.confirmed


@pytest.mark.parametrize("change", ["doubted", "lost", "another leads"])
def test_places_are_open_again_after(change: str) -> None:
    one, local = doubted()
    if change == "doubted":
        one.doubt(12)
    elif change == "lost":
        one.lose([])
    else:
        one.follow(track_at(Pose2()), 1.0, P)
        assert one.follow(track_at(Pose2(0.3, 0, 0)), 1.0, P)
    one.end(13, [OTHER], [OTHER])
    assert not one.confirmed
    one.begin(30, local)
    one.end(31, [OTHER], [OTHER])
    assert not one.confirmed


def place(pose: Pose2, log_evidence: float) -> FoundPlace:
    return FoundPlace(pose, COVARIANCE, -9.0, log_evidence)


@pytest.mark.parametrize(
    ("places", "rivals"),
    [
        ([], 0),
        ([place(Pose2(0.5, 0, 0), EQUAL - 0.1)], 0),
        ([place(Pose2(0.5, 0, 0), EQUAL + 0.1)], 1),
        ([place(Pose2(-0.3, 0, np.pi), 0.0)], 0),
        ([place(Pose2(-0.3, 0, np.pi), 0.0), place(Pose2(0.5, 0, 0), 0.0)], 1),
    ],
    ids=["none", "fits worse", "fits as well", "its image", "its image and another"],
)
def test_a_rival_fits_as_well_and_is_no_image(places: list[FoundPlace], rivals: int) -> None:
    nothing = SimpleNamespace(rescored_at=lambda _: None, scans=1, scans_replayed=1)
    search = cast("PlaceSearch", nothing)
    tracks = [track_at(Pose2(0.3, 0, 0))]
    assert len(rival_poses(search, tracks, places, TURNED, P, EQUAL)) == rivals
