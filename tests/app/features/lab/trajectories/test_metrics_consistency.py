import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.lab.trajectories.consistency import ConsistencyError, anees_bounds, nees

SPREAD = np.diag([1e-6, 4e-6, 1e-4])


def test_nees_is_the_squared_length_in_standard_deviations():
    errors = np.array([[1e-3, 0, 0], [0, 2e-3, 0.02], [0, 0, 0]])
    np.testing.assert_allclose(nees(errors, np.tile(SPREAD, (3, 1, 1))), [1, 5, 0])


@given(st.integers(0, 2**32 - 1))
def test_nees_does_not_depend_on_units_and_axes(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(4, 3, 3)) + 2 * np.eye(3)
    covariances = root @ root.transpose(0, 2, 1)
    errors = rng.normal(size=(4, 3))
    change = np.diag([1e3, 1, 1e-4])
    changed = nees(errors @ change, change @ covariances @ change)
    np.testing.assert_allclose(changed, nees(errors, covariances), rtol=1e-6)
    inverse = np.linalg.inv(covariances)
    np.testing.assert_allclose(
        nees(errors, covariances), np.einsum("ni,nij,nj->n", errors, inverse, errors), rtol=1e-6
    )


def test_bounds_are_those_of_the_book():
    """Example 5.4.2-1: 50 runs, two degrees of freedom: [1.5, 2.6] to one decimal."""
    low, high = anees_bounds(50, 2)
    assert low == pytest.approx(74.222 / 50, abs=1e-4)
    assert high == pytest.approx(129.561 / 50, abs=1e-4)
    assert anees_bounds(1, 3) == pytest.approx((0.2158, 9.3484), abs=1e-4)


def test_an_honest_filter_is_within_the_bounds_and_others_are_not():
    rng = np.random.default_rng(3)
    low, high = anees_bounds(12)
    errors = rng.multivariate_normal(np.zeros(3), SPREAD, (400, 12))
    means = nees(errors.reshape(-1, 3), np.tile(SPREAD, (4800, 1, 1))).reshape(400, 12).mean(axis=1)
    inside = np.mean((means >= low) & (means <= high))
    assert 0.92 <= inside <= 0.98
    assert np.mean(means / 4 < low) > 0.95
    assert np.mean(means * 4 > high) > 0.95


@pytest.mark.parametrize(
    ("covariance", "message"),
    [
        (np.diag([1.0, 0, 1]), "covariance or error 1 is singular: a variance is not positive"),
        (np.diag([1.0, -1, 1]), "1 is singular: a variance is not positive"),
        (np.ones((3, 3)) * 1e-6, "1 is singular: an error in some direction"),
        (np.diag([1, 1, np.nan]), "1 is not finite"),
        (np.eye(3) + np.eye(3, k=1) / 2, "1 is not symmetric"),
    ],
)
def test_what_is_no_covariance_is_named_by_its_index(covariance, message):
    covariances = np.stack([np.eye(3), covariance, np.eye(3)])
    with pytest.raises(ConsistencyError, match=message):
        nees(np.ones((3, 3)), covariances)


def test_other_shapes_and_parameters_are_refused():
    with pytest.raises(ConsistencyError, match=r"valid are shapes \(n, d\) and \(n, d, d\)"):
        nees(np.ones((2, 3)), np.ones((2, 2, 2)))
    for wrong in ((0, 3, 0.95), (1, 0, 0.95), (1, 3, 1.0)):
        with pytest.raises(ValueError, match="valid are 1 and more"):
            anees_bounds(*wrong)
    assert nees(np.zeros((0, 3)), np.zeros((0, 3, 3))).shape == (0,)
