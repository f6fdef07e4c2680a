"""Every filter that can be asked for, and the textbook's Kalman filter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from square_drive import ON_STUB
from stub_drive import DEFAULTS, STUB, matcher_of

from robot.geometry import Array
from robot.localization.filter import Filter
from robot.localization.filter_kinds import FILTERS as OFFERED
from robot.localization.kalman_filter import KalmanFilter

START = DEFAULTS.filter.initial_covariance
SDS = [0.02, 0.02, 0.05]
NARROW = np.diag(np.square(SDS))

Make = Callable[[int], Filter]


def offered(name: str) -> Make:
    return lambda seed: OFFERED[name].make(ON_STUB, np.random.default_rng(seed))


def kalman_of_the_textbook(seed: int) -> Filter:
    beams, rng = DEFAULTS.sensor.max_beams, np.random.default_rng(seed)
    return KalmanFilter(ON_STUB.motion, matcher_of(), STUB, START, beams, rng)


FILTERS = {name: offered(name) for name in OFFERED} | {"textbook": kalman_of_the_textbook}
each_filter = pytest.mark.parametrize("make", FILTERS.values(), ids=FILTERS)


def sds(covariance: Array) -> Array:
    return np.sqrt(np.diag(covariance))
