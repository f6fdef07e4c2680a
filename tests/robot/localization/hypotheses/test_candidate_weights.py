"""What a place that a search has found weighs beside the places that are followed."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stub_drive import DEFAULTS

from robot.geometry import Pose2
from robot.localization.hypotheses.candidate_weights import weigh_places
from robot.localization.hypotheses.rescoring import Rescored
from robot.localization.hypotheses.start_poses import Prior

P = DEFAULTS.hypotheses
COVARIANCE = np.diag(np.square([0.001, 0.001, 0.003]))
START = Pose2(0.1, 0.2, 0.3)
NEW = Pose2(-0.4, 0.1, 2.0)


def weights(
    gain: float, *, log_elsewhere: float, whole: bool, given: bool = True, unseen: float = 0.0
) -> float:
    """Weight of a place whose scans fit better than the followed place's, in all by ``gain``.

    They would fit better by ``unseen`` than that, if all fitted that unseen floor returned there.
    """
    fits, each = np.zeros(8), 1 / (P.scan_worth * 8)
    leader = Rescored(START, COVARIANCE, fits, fits)
    found = Rescored(NEW, COVARIANCE, fits + gain * each, fits + unseen * each)
    search = SimpleNamespace(
        scans=8,
        scans_replayed=8,
        since=Pose2(),
        places_apart_from=lambda poses: [found],
        rescored_at=lambda pose: leader,
    )
    tracks = [SimpleNamespace(pose=START, log_weight=0.0)]
    priors = [Prior(START, COVARIANCE)] if given else []
    (place,) = weigh_places(search, tracks, priors, log_elsewhere, whole, P)  # type: ignore[arg-type]
    assert place.log_evidence == pytest.approx(gain + unseen)
    return place.log_weight


def test_a_place_far_from_the_start_is_as_unlikely_as_a_carried_robot() -> None:
    assert weights(3.0, log_elsewhere=0.0, whole=False) == pytest.approx(3.0 + P.log_kidnapped)


@pytest.mark.parametrize("given", [False, True])
def test_it_is_no_likelier_than_all_places_elsewhere_together(given: bool) -> None:
    elsewhere = 0.5 * P.log_kidnapped
    assert weights(50.0, log_elsewhere=elsewhere, whole=False, given=given) == elsewhere


def test_where_the_short_map_is_all_that_was_seen_scans_alone_decide() -> None:
    assert weights(50.0, log_elsewhere=P.log_kidnapped, whole=True) == pytest.approx(50.0)


def test_unseen_floor_makes_a_place_a_rival_and_not_likelier() -> None:
    usual = weights(-20.0, log_elsewhere=-9.0, whole=True)
    assert weights(-20.0, log_elsewhere=-9.0, whole=True, unseen=19.0) == usual == -20.0
