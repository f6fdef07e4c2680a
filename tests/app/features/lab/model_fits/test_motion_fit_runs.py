"""Odometry and truth are brought to common stamps and cut into windows."""

from __future__ import annotations

import numpy as np
import pytest
from motion_drives import varied_steps

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motions import (
    DriveCorrection,
    MotionRun,
    chained,
    cut_at,
    paired_runs,
    poses_at,
    relative,
)
from app.features.lab.model_fits.windows import windows
from robot.geometry import compose

STEPS = np.array([moved.to_array() for moved in varied_steps(30.0, 0.01)])
POSES = chained(STEPS)
STAMPS = 0.01 * np.arange(len(POSES))
ELSEWHERE = np.array([[2.0, -1.0, 0.7]])


def elsewhere(poses):
    """The same way, seen in another frame."""
    return compose(np.repeat(ELSEWHERE, len(poses), axis=0), poses)


def test_truth_in_another_frame_and_clock_agrees_with_odometry():
    runs = paired_runs(STAMPS, POSES, STAMPS + 0.2, elsewhere(POSES), offset=0.2)
    (run,) = runs
    assert run.duration == pytest.approx(30.0, abs=0.04)
    assert np.diff(run.stamps) == pytest.approx(1 / 30)
    assert np.abs(windows(runs, 5.0).errors).max() < 1e-6


def test_a_wrong_offset_is_seen_in_the_errors():
    runs = paired_runs(STAMPS, POSES, STAMPS + 0.2, elsewhere(POSES))
    assert np.abs(windows(runs, 1.0).errors[:, 2]).max() == pytest.approx(0.2 * 1.5, rel=0.3)


def test_runs_end_where_truth_pauses():
    seen = (STAMPS < 10) | (STAMPS > 10.5)
    seen &= (STAMPS < 20) | (STAMPS > 20.1)
    runs = paired_runs(STAMPS, POSES, STAMPS[seen], elsewhere(POSES)[seen])
    assert [run.stamps[0] for run in runs] == pytest.approx([0, 10.51], abs=0.04)
    assert [run.stamps[-1] for run in runs] == pytest.approx([9.99, 30.0], abs=0.04)
    for run in runs:
        assert not ((run.stamps > 10) & (run.stamps < 10.5)).any()


def test_between_stamps_a_robot_goes_along_the_arc():
    """Stamps of real odometry pause; a straight line there would be a drive sideways."""
    sparse = POSES[::50]
    between = poses_at(STAMPS[:200], STAMPS[::50], sparse)
    assert np.abs(relative(POSES[:200], between)).max() < 1e-9
    run = MotionRun("arc", STAMPS[::50], sparse, sparse).resampled()
    steps = run.steps[62:110]
    assert np.arctan2(steps[:, 1], steps[:, 0]) == pytest.approx(steps[:, 2] / 2, abs=1e-9)


def test_headings_may_pass_the_half_turn():
    poses = np.array([[0.0, 0.0, 3.1], [0.0, 0.0, -3.1]])
    (middle,) = poses_at(np.array([0.5]), np.array([0.0, 1.0]), poses)
    assert abs(middle[2]) == pytest.approx(np.pi)


def test_a_recording_is_cut_in_two():
    runs = paired_runs(STAMPS, POSES, STAMPS, elsewhere(POSES))
    before, after = cut_at(runs, 12.0)
    assert before[0].stamps[-1] == after[0].stamps[0] == pytest.approx(12.0, abs=0.04)
    assert before[0].duration + after[0].duration == pytest.approx(runs[0].duration)
    assert cut_at(runs, -1.0)[0] == [] and cut_at(runs, 99.0)[1] == []


def test_windows_are_counted_as_those_that_fit_side_by_side():
    runs = paired_runs(STAMPS, POSES, STAMPS, elsewhere(POSES))
    of = windows(runs, 5.0, stride=1.0)
    assert of.independent == pytest.approx(6, rel=0.01)
    assert len(of) == 25 + (runs[0].duration >= 30)
    short = [runs[0].part(0, 100), runs[0].part(200, 260)]
    assert len(windows(short, 5.0, keep_short=True)) == 2
    with pytest.raises(FitError, match=r"windows of 5 s are asked; the longest drive has 3\.3 s"):
        windows(short, 5.0)


def test_a_window_ends_where_corrected_odometry_says():
    wrong = DriveCorrection(0.98, 1.03, 0.1)
    truth = chained(wrong.corrected(STEPS))
    runs = paired_runs(STAMPS, POSES, STAMPS, truth, step=0.01)
    assert np.abs(windows(runs, 5.0, wrong).errors).max() < 1e-9
    assert np.abs(windows(runs, 5.0).errors).max() > 0.02


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda stamps, poses: (stamps[::-1], poses), r"truth: stamp 1 .* does not rise"),
        (lambda stamps, poses: (stamps, poses * np.nan), "truth: .* not finite"),
        (lambda stamps, poses: (stamps[:1], poses[:1]), "two or more are needed"),
        (lambda stamps, poses: (stamps + 99, poses), "do not overlap"),
    ],
)
def test_what_is_no_track_of_the_same_drive_is_refused(spoil, message):
    with pytest.raises(FitError, match=message):
        paired_runs(STAMPS, POSES, *spoil(STAMPS, POSES))
