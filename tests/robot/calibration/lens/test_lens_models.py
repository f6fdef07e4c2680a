"""Which model a lens gets: the simplest that is as good, and none that is wild elsewhere."""

from __future__ import annotations

import numpy as np

from robot.calibration.lens.adjustment import LensFit
from robot.calibration.lens.coverage import bare_corners
from robot.calibration.lens.lens_calibration import (
    Rating,
    choice,
    extrapolated,
)
from robot.calibration.lens.sighting import Sighting
from robot.camera import Lens

WIDTH, HEIGHT = 1280, 720


def rating(rms: float, model: str, distortion: list[float]) -> Rating:
    """A lens of 58 degrees, as of a car's camera."""
    matrix = np.array([[1157.0, 0, 666], [0, 1152.0, 389], [0, 0, 1]])
    lens = Lens(WIDTH, HEIGHT, matrix, np.array(distortion), model=model)
    fit = LensFit(lens, np.empty((0, 6)), (np.ones((1, 2)),), np.eye(4 + len(distortion)))
    return Rating(model, np.full(10, rms**2), fit)


USUAL = rating(0.923, "plumb_bob", [-0.24, -0.05, -0.001, 0.0, 0.02])
WILD = rating(0.85, "equidistant", [-0.2, 3.46, -17.8, 29.3])
MILD = rating(0.85, "equidistant", [-0.05, 0.01, -0.02, 0.01])


def test_a_model_whose_terms_cancel_each_other_is_not_chosen_where_another_fits() -> None:
    assert choice([USUAL, WILD]) is USUAL
    assert choice([USUAL, MILD]) is MILD
    assert choice([rating(9.0, "plumb_bob", [0.0] * 5), WILD]) is WILD


def test_a_model_that_is_hardly_better_does_not_replace_a_simpler_one() -> None:
    slightly = rating(0.90, "equidistant", [-0.05, 0.01, -0.02, 0.01])
    assert choice([USUAL, slightly]) is USUAL


def test_a_perfect_pinhole_is_no_fisheye() -> None:
    # Of seven exact pictures: corners are found to some hundredths of a pixel.
    pinhole = rating(0.0635, "plumb_bob", [0.0] * 5)
    assert choice([pinhole, rating(0.060, "equidistant", [-0.33, 0.2, -0.1, 0.0])]) is pinhole


def test_what_is_extrapolated_is_told() -> None:
    assert extrapolated([USUAL], USUAL) < 1e-6
    assert extrapolated([USUAL, WILD], USUAL) < 1e-6
    assert extrapolated([USUAL, MILD], USUAL) > 1.0
    middle = Sighting(np.arange(9), np.full((9, 2), 300.0), (WIDTH, HEIGHT))
    corner = Sighting(np.arange(9), np.full((9, 2), 20.0), (WIDTH, HEIGHT))
    assert len(bare_corners([middle])) == 4
    assert "upper left corner" not in bare_corners([middle, corner])
