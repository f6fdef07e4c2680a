"""Distances between cells are exact, whatever OpenCV computes them with."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from robot.fields.occupancy_grid import FAR_CELLS, cell_distances


@pytest.fixture
def some_threads():
    before = cv2.getNumThreads()
    yield cv2.setNumThreads
    cv2.setNumThreads(before)


@pytest.mark.parametrize("share", [0.3, 0.01, 0.0002])
def test_distances_are_exact_with_any_number_of_threads(some_threads, share):
    """A way in a building ended 4 mm elsewhere when another test had set the threads: OpenCV takes
    another algorithm for one thread than for two, which rounds otherwise."""
    asked = np.random.default_rng(3).random((400, 700)) > share
    exact = distance_transform_edt(asked)
    some_threads(1)
    first = cell_distances(asked)
    for count in (1, 2, 3):
        some_threads(count)
        found = cell_distances(asked)
        assert (np.rint(found.astype(np.float64) ** 2) == np.rint(exact**2)).all()
        assert np.allclose(found, exact, rtol=1e-7, atol=0)
        assert (found == first).all()


def test_far_distances_are_counted_up_to_a_limit():
    asked = np.ones((3, 2 * FAR_CELLS), dtype=bool)
    asked[1, 0] = False
    near, last, beyond = cell_distances(asked)[1, [1, FAR_CELLS - 1, -1]]
    assert (near, last, beyond) == (1, FAR_CELLS - 1, FAR_CELLS)
