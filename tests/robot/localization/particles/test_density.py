"""How densely particles lie."""

import math

import numpy as np
import pytest

from robot.localization.particles.resampling import coarseness

SPREAD = np.diag(np.square([0.1, 0.2, 0.5]))
RANGES = np.array([0.4, 0.4, np.inf])


def of(particles, *shares):
    weights = np.array(shares or (1.0,))
    covariances = np.repeat(SPREAD[None], len(weights), axis=0)
    return coarseness(weights, covariances, particles, RANGES)[0]


def test_it_is_the_side_of_the_space_that_each_particle_has():
    assert of(1000) == pytest.approx((0.1 * 0.2 * 0.5 * 0.4 / 1000) ** (1 / 3))


def test_eight_times_as_many_lie_half_as_far_apart():
    assert of(8000) == pytest.approx(of(1000) / 2)


def test_in_two_clusters_each_has_its_share_of_the_particles():
    assert of(2000, 0.5, 0.5) == pytest.approx(of(1000))


def test_without_a_ray_that_returned_nothing_can_be_said():
    assert coarseness(np.ones(1), SPREAD[None], 10, np.array([math.inf])) == (0.0, 0)
