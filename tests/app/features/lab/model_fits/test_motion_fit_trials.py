"""Simulated motions, driven again and again, and where they end."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motion_fit import fit_drive
from app.features.lab.model_fits.motion_statistics import end_spreads
from app.features.lab.model_fits.motions import DriveCorrection
from app.features.lab.model_fits.simulated_motions import (
    MOTIONS,
    MotionTrial,
    TrialRobot,
    run_motion,
    trials,
)
from robot.description.spec import RobotSpec
from sim.imperfections import Imperfections, draw

pytestmark = pytest.mark.slow

SPEC = RobotSpec.load()
SLIPPING = Imperfections(wheel_radius_sd=0, track_sd=0, slip_sd=0.06, slip_time=0.1)
"""Slip that is forgotten at once, as the motion model supposes."""

KINEMATIC = TrialRobot(SPEC, SPEC, SLIPPING, has_forces=False)
PERFECT = replace(KINEMATIC, imperfections=Imperfections.none())
NOMINAL = DriveCorrection()

ENDS = {
    "straight_forward": (1.0, 0.0, 0.0),
    "straight_back": (-1.0, 0.0, 0.0),
    "turn_left_90": (0.0, 0.0, np.pi / 2),
    "turn_right_90": (0.0, 0.0, -np.pi / 2),
    "turn_left_360": (0.0, 0.0, 0.0),
    "turn_right_360": (0.0, 0.0, 0.0),
    "arc_left_270": (-0.19, 0.19, -np.pi / 2),
    "arc_right_270": (-0.19, -0.19, np.pi / 2),
    "square_ccw": (0.0, 0.0, 0.0),
    "square_cw": (0.0, 0.0, 0.0),
}


@pytest.fixture(scope="module")
def repeated():
    return [run_motion(trial) for trial in trials(KINEMATIC, 12)]


@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_ends_where_it_should(name):
    run = run_motion(MotionTrial(PERFECT, name, 0))
    error = run.truth[-1] - ENDS[name]
    assert np.abs(error[:2]).max() < 0.003
    assert abs(np.sin(error[2])) < 0.005
    assert np.abs(run.odometry[:, :2] - run.truth[:, :2]).max() < 1e-9


def test_a_motion_with_physics_ends_by_odometry_where_it_should():
    true = draw(SPEC, Imperfections(), np.random.default_rng(5))
    run = run_motion(MotionTrial(TrialRobot(SPEC, true), "turn_left_90", 0))
    assert run.odometry[-1, 2] == pytest.approx(np.pi / 2, abs=0.01)
    # It turns by another angle, and stands still in the end.
    assert 0.005 < abs(run.truth[-1, 2] - np.pi / 2) < 0.3
    assert np.abs(run.truth[-1] - run.truth[-5]).max() < 1e-3


def test_a_trial_is_told_by_seed_motion_and_repeat_alone():
    trial = MotionTrial(KINEMATIC, "turn_left_90", 3)
    first, again = run_motion(trial), run_motion(pickle.loads(pickle.dumps(trial)))
    assert (first.odometry == again.odometry).all() and (first.truth == again.truth).all()
    for other in (
        MotionTrial(KINEMATIC, "turn_left_90", 4),
        MotionTrial(replace(KINEMATIC, seed=1), "turn_left_90", 3),
    ):
        assert run_motion(other).truth[-1] != pytest.approx(first.truth[-1], abs=1e-6)


def test_fitted_alphas_predict_the_spread_of_repeated_motions(repeated):
    runs = [run.resampled() for run in repeated]
    fit = fit_drive(runs, track=SPEC.track)
    assert fit.correction.distance == pytest.approx(1, abs=0.01)
    assert fit.correction.turn == pytest.approx(1, abs=0.02)
    fitted = end_spreads(runs, fit.motion.factors, fit.correction)
    assert [one.motion for one in fitted] == list(MOTIONS)
    distances = np.concatenate([one.distances for one in fitted])
    assert distances.mean() == pytest.approx(3, rel=0.2)
    defaults = end_spreads(runs, np.array([0.04, 0.5, 0.04, 0.0004, 0, 0]), NOMINAL)
    for one, before in zip(fitted[:2], defaults[:2], strict=True):
        spread = np.sqrt(np.diag(np.cov(one.errors.T)))
        off, off_before = (np.log(np.sqrt(np.diag(of.predicted)) / spread) for of in (one, before))
        assert np.abs(off).max() < np.log(1.8)
        assert np.abs(off).sum() < np.abs(off_before).sum()


def test_a_spread_needs_repeats(repeated):
    with pytest.raises(FitError, match="straight_forward was driven 1 time"):
        end_spreads(repeated[:10], np.full(6, 0.1), NOMINAL)
