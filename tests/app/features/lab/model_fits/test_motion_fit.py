"""The motion model's alphas are found again in drives that were drawn with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from motion_drives import drawn_runs

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_fit import fit_motion, motion_loss
from app.features.lab.model_fits.windows import Windows, join_windows, windows
from robot.localization.models.odometry_motion import DifferentialMotion

ALPHAS = (0.02, 0.3, 0.05, 0.002)


@pytest.fixture(scope="module")
def drives():
    return drawn_runs(DifferentialMotion(*ALPHAS), 20, 600.0, np.random.default_rng(3))


def test_alphas_lie_in_their_intervals(drives):
    held = np.zeros(4)
    for run in drives:
        low, high = np.array(fit_motion(windows([run], 5.0)).intervals).T
        held += (low <= ALPHAS) & (high >= ALPHAS)
        assert (high < 5 * np.array(ALPHAS)).all(), "intervals that say something"
    assert (held >= 18).all()


def test_all_drives_together_tell_the_alphas_well(drives):
    fit = fit_motion(windows(drives, 5.0))
    assert fit.alphas == pytest.approx(ALPHAS, rel=0.1)
    assert fit.floor_xy < 0.0005 and fit.floor_theta < 0.002


def test_more_data_make_narrower_intervals(drives):
    few, many = (fit_motion(windows(drives[:count], 5.0)).intervals for count in (1, 9))
    widths = [np.ptp(np.log(intervals), axis=1) for intervals in (few, many)]
    assert widths[1] == pytest.approx(widths[0] / 3, rel=0.3)


@pytest.mark.slow
def test_windows_of_several_lengths_tell_the_same_alphas(drives):
    of = join_windows([windows(drives, horizon) for horizon in (5.0, 10.0, 20.0)])
    assert of.weights.sum() == pytest.approx(of.independent * (1 + 1 / 2 + 1 / 4) / 3, rel=1e-3)
    assert fit_motion(of).alphas == pytest.approx(ALPHAS, rel=0.15)


def test_many_short_drives_are_as_good_as_a_long_one(drives):
    pieces = [run.part(k, k + 121) for run in drives[:4] for k in range(0, 18_000, 120)]
    fit = fit_motion(windows(pieces, 5.0, keep_short=True))
    low, high = np.array(fit.intervals).T
    assert fit.independent == len(pieces)
    assert ((low <= ALPHAS) & (high >= ALPHAS)).all()


def test_what_is_there_however_short_the_way_is_told_apart():
    floors = (0.004, 0.02)
    runs = drawn_runs(DifferentialMotion(*ALPHAS), 6, 600.0, np.random.default_rng(5), floors)
    fit = fit_motion(windows(runs, 5.0))
    assert (fit.floor_xy, fit.floor_theta) == pytest.approx(floors, rel=0.25)
    assert fit.alphas == pytest.approx(ALPHAS, rel=0.35)


def test_an_alpha_that_is_not_there_has_an_interval_from_zero():
    without = DifferentialMotion(0.02, 0.3, 0.05, 0.0)
    run = drawn_runs(without, 1, 400.0, np.random.default_rng(2))
    fit = fit_motion(windows(run, 5.0))
    assert fit.intervals[3][0] == 0
    assert fit.alphas[3] <= fit.intervals[3][1] < 0.002


def test_too_few_windows_say_how_many_seconds_are_needed(drives):
    with pytest.raises(FitError, match="at least 20 are needed, which is 100 s"):
        fit_motion(windows([drives[0].part(0, 2000)], 5.0))


@pytest.mark.parametrize(
    ("kept", "message"), [((0, 0, 1), "alpha2 and alpha3"), ((1, 1, 0), "alpha1 and alpha4")]
)
def test_a_motion_that_never_happened_tells_no_alpha(drives, kept, message):
    of = windows(drives[:1], 5.0)
    with pytest.raises(FitError, match=message):
        fit_motion(replace(of, moved=of.moved * np.array(kept)))


def test_derivatives_of_the_likelihood_are_exact(drives):
    of: Windows = windows([drives[0].part(0, 3000)], 5.0)
    rng = np.random.default_rng(0)
    loss = motion_loss(of, of.slopes)
    place = np.array([*ALPHAS, 1e-6, 1e-6, *rng.normal(0, 0.01, 3)])
    _, slope = loss(place)
    for k, nudge in enumerate(np.diag([*1e-5 * place[:6], 1e-6, 1e-6, 1e-6])):
        up, down = (loss(place + sign * nudge)[0] for sign in (1, -1))
        assert slope[k] == pytest.approx((up - down) / (2 * nudge[k]), rel=1e-4)
