"""What is a covariance and what is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.covariance import CovarianceError, by_rows, covariance_from

NUMBERS = st.floats(-10, 10)


@given(st.lists(NUMBERS, min_size=9, max_size=9))
def test_a_product_with_its_transpose_is_a_covariance(numbers):
    root = np.array(numbers).reshape(3, 3)
    covariance = root @ root.T
    assert covariance_from(by_rows(covariance)) == pytest.approx(covariance)


@pytest.mark.parametrize(
    ("numbers", "why"),
    [
        ([1.0] * 8, "8 numbers; valid are 9"),
        ([1, 0.5, 0, 0, 1, 0, 0, 0, 1], "not symmetric"),
        ([1, 2, 0, 2, 1, 0, 0, 0, 1], "eigenvalue is -1"),
        ([1, 0, 0, 0, 1, 0, 0, 0, -0.01], "eigenvalue is -0.01"),
        ([float("nan")] * 9, "beyond"),
        ([1e9, 0, 0, 0, 1, 0, 0, 0, 1], "beyond 10000"),
    ],
)
def test_what_is_no_covariance_is_refused(numbers, why):
    with pytest.raises(CovarianceError, match=why):
        covariance_from(numbers)


def test_what_is_negative_by_rounding_becomes_zero():
    assert covariance_from([1, 0, 0, 0, 1, 0, 0, 0, -1e-7]).tolist() == np.diag([1, 1, 0]).tolist()
    # Fully tied together, written with six digits.
    covariance = covariance_from([1, 0.5, 0, 0.5, 0.2499995, 0, 0, 0, 1])
    assert np.linalg.eigvalsh(covariance)[0] == pytest.approx(0, abs=1e-15)
    assert covariance == pytest.approx(np.array([[1, 0.5, 0], [0.5, 0.25, 0], [0, 0, 1]]), abs=1e-6)


def test_a_covariance_of_nothing_is_one():
    assert covariance_from([0.0] * 9).tolist() == np.zeros((3, 3)).tolist()
