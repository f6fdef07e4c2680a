"""How likely a place is that was found, beside those that are followed already."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from stub_drive import DEFAULTS
from told_filters import at_places

from robot.geometry import Pose2
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.rescoring import Rescored
from robot.localization.parameters import HypothesisParameters

OLD, NEW, OTHER = Pose2(0.2, 0.2, 0.0), Pose2(-0.2, 0.1, 2.0), Pose2(0.0, -0.3, -1.0)
KIDNAPPED = DEFAULTS.hypotheses.log_kidnapped
WORTH = DEFAULTS.hypotheses.scan_worth


def life(pose: Pose2, fit: float) -> Rescored:
    return Rescored(pose, np.diag(np.square([0.005, 0.005, 0.02])), np.full(8, fit), np.zeros(8))


@dataclass
class Done:
    """A search that has ended."""

    found: list[Rescored]
    alive: list[Rescored] = field(default_factory=list)
    whole: bool = True
    since: Pose2 = field(default_factory=Pose2)
    scans: int = 8
    scans_replayed: int = 8
    _parameters = HypothesisParameters()

    rescored_at = PlaceSearch.rescored_at
    places_apart_from = PlaceSearch.places_apart_from
    best_rescored = PlaceSearch.best_rescored


def weights(f: MultiHypothesisFilter) -> dict[Pose2, float]:
    return {track.pose: track.log_weight for track in f._tracks}


def followed(
    *places: Pose2, told: bool = False, elsewhere: float = KIDNAPPED
) -> MultiHypothesisFilter:
    f = at_places(*((place, 0.0) for place in places))
    if not told:
        f._priors = []
    f._elsewhere.log_weight, f._elsewhere.lost = elsewhere, elsewhere > 0
    return f


def test_from_the_start_on_a_place_counts_as_if_it_had_been_found_at_once() -> None:
    f = followed(OLD)
    f._add_places(Done([life(NEW, 2.0)], [life(OLD, 2.0)]))  # type: ignore[arg-type]
    assert weights(f) == {OLD: 0.0, NEW: pytest.approx(0.0)}


@pytest.mark.parametrize(("whole", "told"), [(False, False), (True, True)])
def test_later_or_where_another_start_was_told_it_begins_as_a_kidnapping(
    whole: bool, told: bool
) -> None:
    f = followed(OLD, told=told)
    f._add_places(Done([life(NEW, 2.0)], [life(OLD, 2.0)], whole))  # type: ignore[arg-type]
    assert weights(f)[NEW] == pytest.approx(KIDNAPPED, abs=0.01)


def test_it_is_measured_by_a_place_that_is_still_followed() -> None:
    """The heaviest when the search began fitted badly, and has been given up."""
    f = followed(OLD)
    f._add_places(Done([life(OLD, 3.0), life(NEW, 2.9)], [life(OTHER, 1.0)]))  # type: ignore[arg-type]
    assert weights(f)[NEW] == pytest.approx(-0.1 * 8 * WORTH)


def test_no_place_is_likelier_than_all_elsewhere_together() -> None:
    f = followed(OLD, elsewhere=2.0)
    f._lost_at = 5
    f._add_places(Done([life(NEW, 3.0)], [life(OLD, 0.0)]))  # type: ignore[arg-type]
    assert weights(f)[NEW] - weights(f)[OLD] == pytest.approx(2.0)


def test_where_an_old_track_has_come_to_is_a_place_that_was_found_like_others() -> None:
    f = followed(OLD)
    f._lost_at = 5
    f._tracks[0].born = 6
    f._add_places(Done([life(NEW, 2.5)], [life(OLD, 2.5)]))  # type: ignore[arg-type]
    assert weights(f)[NEW] == pytest.approx(0.0)
    assert f._elsewhere.log_weight > math.log(0.05), "and it may be at neither of them"


def test_a_place_that_was_held_before_and_fits_again_was_not_lost() -> None:
    f = followed(OLD)
    f._lost_at = 5
    f._add_places(Done([life(NEW, 2.5)], [life(OLD, 2.5)]))  # type: ignore[arg-type]
    assert weights(f)[NEW] == pytest.approx(f.setup.hypotheses.log_kidnapped)
