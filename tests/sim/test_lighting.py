"""One lamp over a floor."""

import numpy as np
import pytest

from robot.fields.floor_picture import FloorPicture
from sim.clutter import add_uneven_light

FLOOR = FloorPicture(np.full((300, 400), 200, dtype=np.uint8), 0.01, (0.0, 0.0, 4.0, 3.0))


def test_without_a_lamp_the_floor_is_as_it_was():
    assert add_uneven_light(FLOOR, 0.0, np.random.default_rng(0)) is FLOOR


@pytest.mark.parametrize("seed", range(5))
def test_light_falls_from_below_the_lamp_to_the_farthest_corner(seed):
    image = add_uneven_light(FLOOR, 0.5, np.random.default_rng(seed)).image.astype(int)
    assert image.max() == 200
    assert image.min() == pytest.approx(100, abs=1)
    corners = [image[0, 0], image[0, -1], image[-1, 0], image[-1, -1]]
    assert image.min() == min(corners)
    row, column = np.unravel_index(image.argmax(), image.shape)
    assert 0.05 * 300 < row < 0.95 * 300 and 0.05 * 400 < column < 0.95 * 400
    assert (np.diff(image[row, column:]) <= 0).all() and (np.diff(image[row:, column]) <= 0).all()


def test_the_same_seed_hangs_the_same_lamp():
    one, same, other = (
        add_uneven_light(FLOOR, 0.5, np.random.default_rng(seed)).image for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, same)
    assert (one != other).any()
    assert (FLOOR.image == 200).all()
