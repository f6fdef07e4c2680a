"""The drives by which a constant of calibration is judged."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import pytest

from benchmarks import constant_calibrations
from robot.calibration.adjustment import CalibrationError


def refused(*drive: object) -> NoReturn:
    raise CalibrationError("it saw no tape")


@pytest.mark.slow
def test_calibrations_are_judged_by_the_truth_and_a_refused_one_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constant_calibrations, "CALIBRATED", constant_calibrations.CALIBRATED[:1])
    kept = tmp_path / "drives"
    usual = constant_calibrations.tried(constant_calibrations.recorded(kept), 0)
    assert usual["map's edges off [mm]"] < 1 and usual["not drawn [%]"] < 5
    assert usual["calibrated path off [mm]"] < 2 and usual["at most [sd]"] < 4
    assert usual["refused"] == 0
    monkeypatch.setattr(constant_calibrations, "calibrate", refused)
    lost = constant_calibrations.tried(constant_calibrations.recorded(kept), 0)
    assert lost["refused"] == 1 and lost["each"][-1] == usual["each"][-1]
