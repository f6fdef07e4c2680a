"""A calibration's drive that the robot itself interrupts: people are told why."""

from dataclasses import replace
from datetime import UTC, datetime

from engine_runs import kinematic, run

from app.features.calibration.drive_calibrator import DriveCalibrator


def test_a_fault_of_the_robot_ends_the_drive_and_is_named() -> None:
    program = kinematic()
    tick = run(program, 0.1)[-1]
    calibrator = DriveCalibrator(program, lambda: datetime(2026, 11, 23, tzinfo=UTC))
    calibrator.begin()
    for elapsed, mode, faults in ((0.0, "calibrate", ()), (0.1, "idle", ("A wheel is blocked.",))):
        reading = replace(tick.reading, stamp=tick.stamp + elapsed, faults=faults)
        program.engine.publish(replace(tick, stamp=reading.stamp, mode=mode, reading=reading))
    calibrator._follower.wait(60.0)
    calibrator.close()
    assert calibrator.drive is not None
    assert calibrator.drive.state == "failed"
    assert calibrator.drive.words == "the robot stopped: A wheel is blocked."
