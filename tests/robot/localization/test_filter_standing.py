"""What every filter knows of itself, and how it takes steps that err more than usual."""

from __future__ import annotations

import numpy as np
from filter_makers import NARROW, Make, each_filter, sds
from stub_drive import Drive, check_sound, follow, near

from robot.geometry import Pose2
from robot.localization.estimate import Standing
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter


@each_filter
def test_told_where_it_is_it_is_as_given_until_its_scans_confirm_it(make: Make) -> None:
    """A filter that makes no search has nothing to confirm it by."""
    f, drive = make(0), Drive()
    f.set_pose(drive.true, NARROW)
    searches = isinstance(f, MultiHypothesisFilter)
    assert f.standing is (Standing.GIVEN if searches else Standing.CONFIRMED)
    follow(f, drive, 2.5)
    assert f.standing is Standing.CONFIRMED


@each_filter
def test_loosened_its_steps_err_so_many_times_more(make: Make) -> None:
    """And as usual again when it is told so."""
    known = np.diag(np.square([1e-4, 1e-4, 1e-4]))
    grown = []
    for factor in (1.0, 3.0):
        f = make(0)
        f.set_pose(Pose2(0.1, 0.0, 0.5), known)
        f.loosen(factor)
        for _ in range(30):
            f.predict(Pose2(0.01, 0.0, 0.02))
        check_sound(f)
        there = Pose2(0.1, 0.0, 0.5)
        for _ in range(30):
            there = there @ Pose2(0.01, 0.0, 0.02)
        assert near(f.hypotheses[0].pose, there, 0.01, 0.03)
        grown.append(sds(f.hypotheses[0].covariance))
    np.testing.assert_allclose(grown[1] / grown[0], 3.0, rtol=0.25)
    f = make(0)
    f.loosen(3.0)
    f.loosen(1.0)
    f.set_pose(Pose2(0.1, 0.0, 0.5), known)
    for _ in range(30):
        f.predict(Pose2(0.01, 0.0, 0.02))
    np.testing.assert_allclose(sds(f.hypotheses[0].covariance), grown[0], rtol=0.1)


@each_filter
def test_loosened_it_still_stays_on_the_robot(make: Make) -> None:
    f, drive = make(0), Drive()
    f.set_pose(drive.true @ Pose2(0.01, -0.01, 0.03), NARROW)
    f.loosen(4.0)
    errors = follow(f, drive, 2.0)
    assert max(errors[30:]) < 0.01
    assert f.standing is Standing.CONFIRMED
    check_sound(f)


@each_filter
def test_asked_to_search_anew_it_stays_sound_and_finds_its_place(make: Make) -> None:
    f, drive = make(0), Drive()
    f.set_pose(drive.true, NARROW)
    follow(f, drive, 0.5)
    f.search_anew()
    check_sound(f)
    errors = follow(f, drive, 6.0)
    assert errors[-1] < 0.01
    assert f.standing is Standing.CONFIRMED
    check_sound(f)
