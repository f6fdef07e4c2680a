"""What tape tells of a camera before a drive's path is known."""

from dataclasses import replace

import numpy as np
import pytest
from calibrations import SPEC, SQUARE

from robot.calibration import drive_path
from robot.calibration.camera_from_tape import Guess
from robot.calibration.drive_log import DriveLog
from robot.calibration.drive_path import FieldDrive
from robot.description.unknowns import COUNT
from robot.scanning.tape import Tape


def test_tape_of_several_widths_tells_nothing_of_a_camera_yet(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """White tape and dashes half as wide were both taken for the white tape."""
    askew = Guess(np.full(COUNT, 0.01))
    monkeypatch.setattr(drive_path, "camera_from_tape", lambda *_: askew)
    nothing = np.full((2, 4, 2), np.nan)
    log = DriveLog(np.arange(2.0), nothing, np.arange(2.0), np.zeros((2, 2)))
    lane = replace(SQUARE, tape=(Tape(0.048, light=True), Tape(0.024, light=True)))
    assert FieldDrive(log, SPEC, SQUARE).guess is askew
    np.testing.assert_array_equal(FieldDrive(log, SPEC, lane).guess.values, np.zeros(COUNT))
