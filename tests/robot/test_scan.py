"""A scan is ranges by bearing around a centre."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Pose2
from robot.scan import Scan


def test_a_scan_knows_its_hits_and_their_places() -> None:
    scan = Scan(1.0, np.array([0, math.pi / 2, 1.0]), np.array([2.0, 1.0, np.inf]), Pose2(0.1))
    assert scan.hit.tolist() == [True, True, False]
    np.testing.assert_allclose(scan.points(), [[2.1, 0], [0.1, 1]], atol=1e-12)
    turned = Scan(1.0, np.zeros(1), np.ones(1), Pose2(0, 0, math.pi / 2))
    np.testing.assert_allclose(turned.points(), [[0, 1]], atol=1e-12)
