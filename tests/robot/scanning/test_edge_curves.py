"""Lines and arcs through the entries of neighbouring rays, which come from (0, 0)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Array
from robot.scanning.edge_curves import FEWEST, distance, fit_arc, fit_line, meet, place

NOISE = 0.00005
"""Of an entry, across the edge [m]."""
WIDTH = 0.050
LONG = 0.080
"""Of an edge [m]: as much as a ray's neighbours reach to both sides."""

radii = st.floats(0.07, 2.0)
sides = st.sampled_from([1, -1])
angles = st.floats(-math.pi, math.pi)
distances = st.floats(0.15, 1.0)


@dataclass(frozen=True)
class Circle:
    """A round edge whose nearest point lies straight on in a direction."""

    radius: float
    side: int
    """1 where the rays come from outside, -1 from inside."""
    direction: float
    away: float
    """Of the nearest point [m]."""

    @property
    def centre(self) -> Array:
        return (self.away + self.side * self.radius) * self.ahead

    @property
    def ahead(self) -> Array:
        return np.array([math.cos(self.direction), math.sin(self.direction)])

    @property
    def curvature(self) -> float:
        return self.side / self.radius

    def off(self, points: Array) -> Array:
        """Signed distance of points (n, 2), positive where the rays come from."""
        found: Array = self.side * (np.hypot(*(points - self.centre).T) - self.radius)
        return found

    def points(self, along: Array, off: Array | float = 0.0) -> Array:
        """Where one is by a way along the edge from its nearest point, and so far off it."""
        turn = along / self.radius
        aside = np.array([-self.ahead[1], self.ahead[0]])
        back = -self.side * np.cos(turn)[:, None] * self.ahead + np.sin(turn)[:, None] * aside
        found: Array = self.centre + (self.radius + self.side * np.asarray(off))[..., None] * back
        return found

    def chain(self, rng: np.random.Generator, count: int = 25, noise: float = NOISE) -> Array:
        along = np.linspace(-LONG / 2, LONG / 2, count)
        entries = self.points(along, noise * rng.standard_normal(count))
        return np.hstack([entries, self.points(along, -WIDTH)])

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Circle:
        radius = math.exp(rng.uniform(math.log(0.07), math.log(2.0)))
        side = 1 if rng.random() < 0.5 else -1
        return cls(radius, side, rng.uniform(-3, 3), rng.uniform(0.15, 1.0))

    def curve(self) -> Array:
        """As a fit should find it, its middle at the nearest point."""
        return np.array([*-self.ahead, -self.away, 0.0, 0.0, self.curvature])


def fitted(chain: Array) -> Array:
    curve = np.empty(6)
    fit_line(chain, 0, len(chain) - 1, curve)
    fit_arc(chain, 0, len(chain) - 1, curve)
    return curve


def curvature_sd(chain: Array, curve: Array) -> float:
    """Standard error of a parabola's curvature, by least squares."""
    v = np.array([place(*entry, curve) for entry in chain[:, :2]])
    design = np.column_stack([np.ones_like(v), v, 0.5 * v * v])
    return NOISE * math.sqrt(np.linalg.inv(design.T @ design)[2, 2])


def test_curvature_errs_as_noise_lets_it_and_entries_lie_on_the_arc() -> None:
    rng, errors, worst = np.random.default_rng(0), [], []
    for _ in range(400):
        circle = Circle.drawn(rng)
        chain = circle.chain(rng)
        curve = fitted(chain)
        errors.append((curve[5] - circle.curvature) / curvature_sd(chain, curve))
        worst.append(curve[3])
    assert np.mean(np.abs(errors) < 3) > 0.99 and np.abs(errors).max() < 4
    assert abs(np.mean(errors)) < 0.15 and 0.9 < np.std(errors) < 1.1
    assert max(worst) < 4.5 * NOISE


@given(radii, sides, angles, distances)
def test_without_noise_the_circle_is_found(
    radius: float, side: int, direction: float, away: float
) -> None:
    circle = Circle(radius, side, direction, away)
    curve = fitted(circle.chain(np.random.default_rng(0), noise=0.0))
    assert curve[5] == pytest.approx(circle.curvature, abs=1e-3)
    assert curve[3] < 1e-6
    assert np.hypot(*curve[:2]) == pytest.approx(1)
    np.testing.assert_allclose(curve[:2], -circle.ahead, atol=1e-4)


def test_a_line_stays_a_line() -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        line = Circle(1e9, 1, rng.uniform(-3, 3), rng.uniform(0.15, 1.0))
        chain = line.chain(rng)
        straight = np.empty(6)
        fit_line(chain, 0, len(chain) - 1, straight)
        assert straight[5] == 0 and straight[3] < 4.5 * NOISE
        assert straight[2] < 0, "the normal points toward the rays"
        bent = fitted(chain)
        assert abs(bent[5]) < 4 * curvature_sd(chain, bent)
        np.testing.assert_allclose(bent[:3], straight[:3], atol=0.01)
        exact = line.chain(rng, noise=0.0)
        assert abs(fitted(exact)[5]) < 1e-4


@given(radii, sides, angles, distances, st.floats(-0.3, 0.3), st.floats(-0.06, 0.06))
def test_the_distance_from_an_arc_is_exact(
    radius: float, side: int, direction: float, away: float, along: float, off: float
) -> None:
    circle = Circle(radius, side, direction, away)
    point = circle.points(np.array([along]), np.array([off]))
    assert distance(*point[0], circle.curve()) == pytest.approx(off, abs=1e-9)
    assert circle.off(point)[0] == pytest.approx(off, abs=1e-9)


@given(radii, sides, angles, distances, st.floats(-0.04, 0.04), st.floats(-0.001, 0.001))
def test_a_ray_meets_the_arc_on_the_arc(
    radius: float, side: int, direction: float, away: float, along: float, off: float
) -> None:
    """The tangent is that of the point where the ray to an entry beside the arc cuts it."""
    circle = Circle(radius, side, direction, away)
    x, y = circle.points(np.array([along]), np.array([off]))[0]
    line = np.empty(3)
    meet(x, y, circle.curve(), line)
    ahead = np.array([x, y]) / math.hypot(x, y)
    met = line[2] / (line[:2] @ ahead) * ahead
    assert circle.off(met[None])[0] == pytest.approx(0, abs=1e-6)
    outward = circle.side * (met - circle.centre) / radius
    np.testing.assert_allclose(line[:2], outward, atol=1e-4)


def test_a_line_is_its_own_tangent() -> None:
    line = np.empty(3)
    meet(0.3, 0.1, np.array([-1.0, 0.0, -0.3, 0.0, 0.1, 0.0]), line)
    np.testing.assert_array_equal(line, [-1.0, 0.0, -0.3])


def test_too_few_entries_make_no_arc() -> None:
    chain = Circle(0.1, 1, 0.0, 0.3).chain(np.random.default_rng(0), FEWEST - 1)
    assert fitted(chain)[3] == np.inf
    assert np.isfinite(fitted(Circle(0.1, 1, 0.0, 0.3).chain(np.random.default_rng(0), FEWEST))[3])
