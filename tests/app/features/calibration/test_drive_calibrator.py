"""A running robot is calibrated by driving: commanded, followed, applied, undone."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from engine_runs import drive, kinematic, run

from app.engine.commands import check
from app.engine.driving import GAP_S
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.commands import DRIVE
from app.features.calibration.drive_calibrator import FEWEST_S, DriveCalibrator
from app.features.calibration.messages import CalibrateCommand
from app.features.calibration.routes import calibration_message, drive_message
from app.messages.commands import SetCalibrationCommand
from app.messages.driving_commands import StopCommand
from app.settings.profile_files import before
from app.settings.profiles import own_profile
from robot.calibration.programme import LONGEST_S
from robot.description.profile import Profile, load_profile
from robot.description.unknowns import NAMES, ROBOT
from robot.errors import CommandError
from robot.estimation.fit_quality import FitQuality
from robot.geometry import Twist2
from robot.interface import Frame
from sim.simulated import PERIOD

pytestmark = pytest.mark.slow

START = CalibrateCommand(type="calibrate", start=True)
CALIBRATE = CalibrateCommand(type="calibrate")
STOP = StopCommand(type="stop")
MADE = datetime(2026, 11, 23, 15, 30, tzinfo=UTC)
WRONG = {"camera_pitch": 0.02, "left_radius": 0.03}


class Bench:
    """A program that is stepped by hand, with its calibrator."""

    def __init__(self, **settings) -> None:
        self.program: Program = kinematic(**settings)
        self.calibrator = DriveCalibrator(self.program, lambda: MADE)
        run(self.program, 0.2)

    def begin(self, seconds: float) -> Snapshot:
        """Drive for so long."""
        self.calibrator.begin()
        run(self.program, PERIOD, START)
        return run(self.program, seconds, CALIBRATE)[-1]

    def end(self) -> Snapshot:
        """Let the robot stand until the drive is adjusted; return a tick after that."""
        run(self.program, 1.0)
        self.wait()
        return run(self.program, 0.1)[-1]

    def wait(self) -> None:
        """Wait for the end of the calibrator's thread."""
        self.calibrator._follower.wait(60.0)


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench()
    yield made
    made.calibrator.close()


@pytest.fixture(scope="module")
def calibrated() -> Iterator[Bench]:
    """A robot with perfect wheels that is calibrated by a short drive, as a real one would be."""
    made = Bench()
    made.program = replace(
        made.program, config=replace(made.program.config, robot="buildhat", profile="")
    )
    made.calibrator = DriveCalibrator(made.program, lambda: MADE)
    made.begin(FEWEST_S + 1.0)
    made.calibrator.finish()
    made.end()
    yield made
    made.calibrator.close()


def test_it_drives_the_programme_as_long_as_it_is_renewed(bench: Bench) -> None:
    shown = run(bench.program, PERIOD, START) + run(bench.program, 1.5, CALIBRATE)
    assert {tick.mode for tick in shown} == {"calibrate"}
    assert shown[-1].twist.v > 0.1
    assert shown[-1].twist.omega > 0.5
    still = run(bench.program, 0.5)
    assert (still[-1].mode, still[-1].twist) == ("calibrate", Twist2())
    on = run(bench.program, 0.1, CALIBRATE)
    assert on[-1].twist.v > 0, "it goes on after a moment without renewals"
    late = run(bench.program, GAP_S + 0.2)
    assert (late[-1].mode, late[-1].twist) == ("idle", Twist2())


def test_it_ends_by_itself_and_renewals_start_no_other(bench: Bench) -> None:
    driving = bench.program.engine.controls.driving
    odometry = bench.program.engine.controls.odometry.at(0.0)
    driving.perform(DRIVE, 0.0, start=True)
    modes = []
    for stamp in np.arange(0.0, LONGEST_S + 2.0, 0.1).tolist():
        driving.perform(DRIVE, stamp, start=False)
        driving.update(replace(odometry, stamp=stamp))
        modes.append(driving.mode)
    assert modes.index("idle") == round(LONGEST_S / 0.1)
    assert set(modes[modes.index("idle") :]) == {"idle"}


def test_after_a_stop_renewals_start_no_other(bench: Bench) -> None:
    run(bench.program, PERIOD, START)
    assert run(bench.program, 0.5, CALIBRATE)[-1].mode == "calibrate"
    assert run(bench.program, PERIOD, STOP)[-1].mode == "idle"
    assert {tick.mode for tick in run(bench.program, 1.0, CALIBRATE)} == {"idle"}


def test_the_robot_is_calibrated_by_the_drive(calibrated: Bench) -> None:
    shown = run(calibrated.program, 0.1)[-1]
    told = drive_message(calibrated.calibrator.drive, shown.stamp)
    assert told is not None
    assert (told.state, told.message) == ("done", None)
    assert told.seconds == pytest.approx(FEWEST_S + 1.0, abs=0.1)
    assert shown.spec.measured == "2026-11-23, 21 s of driving on square"
    profile = Profile.of(shown.spec)
    assert (np.abs(profile.values) < 4 * profile.sd).all(), "it is as described"
    assert shown.pose is not None and shown.truth is not None
    assert shown.pose.distance_to(shown.truth) < 0.002


def test_its_result_is_told_in_units_for_people(calibrated: Bench) -> None:
    spec = run(calibrated.program, 0.1)[-1].spec
    told = calibration_message(spec, calibrated.calibrator)
    assert [unknown.name for unknown in told.unknowns] == list(NAMES[:ROBOT])
    pitch = told.unknowns[NAMES.index("camera_pitch")]
    assert (pitch.unit, pitch.learnt) == ("degree", True)
    assert pitch.prior == pytest.approx(1.96 * 2.25)
    assert 0 < pitch.interval < 0.2
    assert told.undoable
    assert told.position is not None and 0 < told.position < 0.005


def test_a_real_robot_s_profile_is_written_and_undo_goes_back(calibrated: Bench) -> None:
    program, calibrator = calibrated.program, calibrated.calibrator
    path = own_profile(program.robot.spec.name)
    after = run(program, 0.1)[-1].spec
    written = load_profile(path)
    assert written.to_toml() == after.profile
    fit = FitQuality.of_table(written.fit)
    assert fit.contradictions == ()
    assert math.isfinite(fit.residual)
    # After another start there is the profile only: it says the same.
    told = calibration_message(after, DriveCalibrator(program, lambda: MADE))
    assert told.facts == list(fit.facts)
    assert told.remarks == list(fit.remarks)
    calibrator.undo()
    spec = run(program, 0.1)[-1].spec
    assert spec.measured == ""
    np.testing.assert_allclose(spec.robot_from_camera, program.robot.spec.robot_from_camera)
    assert not path.exists()
    assert load_profile(before(path)).made == MADE
    calibrator.undo()
    assert run(program, 0.1)[-1].spec.profile == after.profile
    assert load_profile(path).made == MADE


def test_a_stop_leaves_the_robot_as_it_was(bench: Bench) -> None:
    spec = bench.begin(3.0).spec
    run(bench.program, PERIOD, STOP)
    assert bench.end().spec is spec
    told = bench.calibrator.drive
    assert told is not None
    assert (told.state, told.words) == ("failed", "the drive was stopped after 3 s")
    assert not bench.calibrator.undoable


def test_a_drive_that_shows_no_tape_leaves_the_robot_as_it_was(bench: Bench) -> None:
    tick = run(bench.program, 0.1)[-1]
    engine, calibrator = bench.program.engine, bench.calibrator
    dark = np.zeros_like(tick.frame.image)
    calibrator.begin()
    for elapsed in np.arange(0.0, LONGEST_S + 2.0, 0.5).tolist():
        stamp, mode = tick.stamp + elapsed, "calibrate" if elapsed < LONGEST_S else "idle"
        reading = replace(tick.reading, stamp=stamp, frame=Frame(stamp, dark))
        engine.publish(replace(tick, stamp=stamp, mode=mode, reading=reading))
    bench.wait()
    assert (calibrator.drive.state, calibrator.drive.words) == (
        "failed",
        "no picture of the drive shows tape of this width",
    )
    assert not [item for item in engine.commands.take() if isinstance(item, SetCalibrationCommand)]


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.0, "no calibration drives"), (3.0, "driven for 3 s; valid is 20 s")]
)
def test_what_cannot_be_finished_is_refused(bench: Bench, seconds: float, words: str) -> None:
    if seconds:
        bench.begin(seconds)
        # The thread has seen the first tick as soon as it tells when it began.
        while bench.calibrator.drive is None or bench.calibrator.drive.began is None:
            run(bench.program, PERIOD, CALIBRATE)
    with pytest.raises(CommandError, match=words):
        bench.calibrator.finish()


def test_where_nothing_was_calibrated_nothing_is_undone(bench: Bench) -> None:
    with pytest.raises(CommandError, match="nothing to undo"):
        bench.calibrator.undo()


def test_a_robot_that_does_not_begin_is_told(bench: Bench) -> None:
    bench.calibrator.begin()
    run(bench.program, 3.0, drive(v=0.05))
    bench.end()
    assert bench.calibrator.drive is not None
    assert bench.calibrator.drive.words == "the robot did not begin to drive"


def test_a_field_without_tape_is_refused(bench: Bench) -> None:
    field = replace(bench.program.field, tape=())
    with pytest.raises(CommandError, match="not of tape"):
        check(CALIBRATE, replace(bench.program, field=field))
