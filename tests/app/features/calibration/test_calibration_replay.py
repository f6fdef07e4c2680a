"""A calibration while a robot runs is recorded, and repeated where it was."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run
from recordings import begin, recorder_of
from replays import go, to_the_end

from app.engine.commands import check
from app.engine.profile_command import calibration_command
from app.features.calibration.messages import CalibrateCommand, UndoCalibrationCommand
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import PRIORS, ROBOT
from robot.errors import CommandError
from sim.simulated import PERIOD

VALUES = np.array([0.01, -0.02, 0.03, 0.002, -0.003, 0.004, 0.02, 0.04, 0.01, -0.02, 0.03])
MADE = Profile(
    RobotSpec.load().name,
    datetime(2026, 11, 23, 15, 30, tzinfo=UTC),
    "a test",
    VALUES,
    PRIORS[:ROBOT] / 10,
)


@pytest.fixture(scope="module")
def replayed(tmp_path_factory):
    """A recording of two seconds, with a calibration in the middle; its replay and last tick."""
    program = kinematic(seed=1)
    recorder, publisher = recorder_of(program, tmp_path_factory.mktemp("recordings"))
    folder = begin(recorder, publisher)
    for tick in range(round(2.0 / PERIOD)):
        told = (calibration_command(MADE),) if tick == round(1.0 / PERIOD) else ()
        shown = run(program, PERIOD, EIGHT, *told)[-1]
        publisher.tick(shown)
    recorder.close()
    return open_replay(folder, ReplayOptions()), shown


@pytest.mark.slow
def test_a_replay_repeats_it_and_going_back_takes_it_back(replayed):
    program, shown = replayed
    timeline = program.replay.timeline
    last = to_the_end(timeline)[-1]
    assert last.spec.profile == shown.spec.profile
    # The recorded pictures are JPEGs, so the poses are not the same to the last digit.
    np.testing.assert_allclose(last.pose.to_array(), shown.pose.to_array(), atol=0.01)
    before = go(timeline, 0.5)
    assert before.spec.profile == ""
    assert before.calibrated == -np.inf
    assert go(timeline, 1.9).spec.profile == shown.spec.profile


@pytest.mark.parametrize(
    "command",
    [
        CalibrateCommand(type="calibrate", start=True),
        UndoCalibrationCommand(type="undo_calibration"),
    ],
)
def test_a_replay_cannot_be_calibrated_by_driving(replayed, command):
    with pytest.raises(CommandError, match="this is a replay, which cannot be driven"):
        check(command, replayed[0])
