"""Being at none of the places that are followed is as likely as they fit badly."""

from __future__ import annotations

import numpy as np
import pytest
from square_drive import NARROW, ON_STUB, setup_of
from stub_drive import ENTRIES, STUB, Drive

from robot.geometry import Pose2
from robot.localization.hypotheses.kidnapping import FRESH, Kidnapping
from robot.localization.localizer import make_filter
from robot.scan import rays_of


@pytest.mark.parametrize("fit_sd", [0.003, 0.1])
def test_how_exact_a_range_is_said_to_be_does_not_make_it_lost(fit_sd: float) -> None:
    drive = Drive(Pose2(0.1, 0.1, 0.3))
    f = make_filter(setup_of(STUB, ENTRIES, fit_sd=fit_sd), np.random.default_rng(0))
    f.set_pose(drive.true, NARROW)
    for moved, scan in drive.eight(1.5):
        f.predict(moved)
        f.correct(scan)
    assert f.hypotheses[0].weight > 0.95


def test_scans_in_a_row_that_fit_no_place_are_counted() -> None:
    """They are what a search keeps, as the robot was carried off before them."""
    rays, evidence = rays_of(Drive().scan(), 60), ON_STUB.evidence
    anywhere = evidence.background_log_likelihood(rays)
    elsewhere, counts = Kidnapping(FRESH), []
    for better in (1.0, -1.0, -1.0, 1.0, -1.0):
        elsewhere.weigh(anywhere + better, rays, evidence, ON_STUB.hypotheses)
        counts.append(elsewhere.doubts)
    assert counts == [0, 1, 2, 0, 1]
