"""Sensor models as students write them first: what is wrong is said while the robot drives."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.lab.evaluation.integrity.claims import Claims, follow_claims
from app.lab.evaluation.integrity.drives import TrialDrive, lap_drive
from app.lab.evaluation.integrity.measures import misleading
from app.settings.config import Config
from robot.localization.estimate import Cause

CONFIG = Config(robot="sim", map="stub", seed=1003)
DOUBTED = 5.0
"""Within so long [s]."""

GOOD = """
import numpy as np


class Model:
    scale, degrees = 1.0, False

    def __init__(self, field):
        self.starts, self.ways = field.edges[:, :2], field.edges[:, 2:] - field.edges[:, :2]

    def log_likelihood(self, poses, scan):
        x, y = scan.points()[::5].T
        heading = np.degrees(poses[:, 2:]) if self.degrees else poses[:, 2:]
        c, s = np.cos(heading), np.sin(heading)
        ends = np.stack([c * x - s * y, s * x + c * y], axis=2) + poses[:, None, :2]
        off = np.full(ends.shape[:2], 0.03)
        for start, way in zip(self.starts, self.ways):
            along = np.clip((ends - start) @ way / (way @ way), 0, 1)
            off = np.minimum(off, np.linalg.norm(ends - start - along[..., None] * way, axis=2))
        return self.answer(-0.5 * ((self.scale * off / 0.004) ** 2).sum(axis=1))

    def answer(self, log_likelihood):
        return log_likelihood
"""

NONSENSE = {
    "a constant": "    def answer(self, log_likelihood):\n        return 0 * log_likelihood\n",
    "the likelihood for its logarithm": (
        "    def answer(self, log_likelihood):\n        return np.exp(log_likelihood)\n"
    ),
    "its opposite": "    def answer(self, log_likelihood):\n        return -log_likelihood\n",
    "degrees for radians": "    degrees = True\n",
    "metres for millimetres": "    scale = 0.001\n",
}


@pytest.fixture(scope="module")
def lap() -> TrialDrive:
    return lap_drive(CONFIG, 0.45)


def claims_with(lap: TrialDrive, folder: Path, changed: str = "") -> Claims:
    path = folder / "model.py"
    path.write_text(f"{GOOD}\n\nclass Tried(Model):\n{changed or '    pass'}\n")
    config = Config(robot="sim", map="stub", seed=1003, sensor_model=f"{path}:Tried")
    return follow_claims(lap, config, "known")


@pytest.mark.parametrize("kind", NONSENSE)
def test_a_model_that_makes_no_sense_is_named_within_seconds(
    lap: TrialDrive, tmp_path: Path, kind: str
) -> None:
    claims = claims_with(lap, tmp_path, NONSENSE[kind])
    first = next(place for place, cause in enumerate(claims.causes) if cause is not None)
    assert claims.causes[first] is Cause.MODEL
    assert claims.stamps[first] - claims.stamps[0] < DOUBTED
    assert misleading(claims)[claims.stamps - claims.stamps[0] > DOUBTED].mean() < 0.01


def test_a_good_model_is_never_doubted(lap: TrialDrive, tmp_path: Path) -> None:
    claims = claims_with(lap, tmp_path)
    assert set(claims.causes) == {None}
    assert not misleading(claims).any()
