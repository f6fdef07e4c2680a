"""Where exactly is the robot, if it is about here? Rays laid on the edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array, Pose2

NEAR, FAR, END = 0.015, 0.06, 0.06
"""An edge so close to where sight begins or ends [m] may be missed: tape is seen as a whole."""
STEPS = 6
"""Gauss-Newton steps, at most; from a few centimetres off four are enough."""


@dataclass(frozen=True, slots=True)
class Match:
    """A pose at which rays fit the map best."""

    pose: Pose2
    information: Array = field(repr=False)
    """(3, 3) inverse of the covariance [m, m, rad]; singular along what is not measured."""
    used: int
    """Rays that fit."""


@dataclass(frozen=True, slots=True)
class Past:
    """A stretch of the way: m scans, and how the robot moved between them."""

    moves: Array
    """(m, 3) [m, m, rad] the step before each scan, seen from its start."""
    noise: Array
    """(m, 3, 3) covariance of each step, seen from its start."""
    rays: Array
    """(m, k, 6) of each scan."""
    start_information: Array
    """(3, 3) how well a pose at the first scan is known."""


@dataclass(frozen=True, slots=True)
class Life:
    """What a hypothesis would have come to."""

    pose: Pose2
    """At the last scan."""
    information: Array
    """(3, 3) inverse covariance [m, m, rad]."""
    fits: Array
    """(m,) log-likelihood of each scan, on average of its rays."""


@dataclass(frozen=True, slots=True)
class ScanMatcher:
    """Lays rays on the edges of a field, and says how well they fit."""

    index: EdgeIndex = field(repr=False)
    sharp: NDArray[np.bool_] = field(repr=False)
    range_max: float
    """How far rays reach [m]."""
    sd: float
    """Standard deviation of a range [m]."""
    gate: float
    """Ranges that are farther off than this do not measure the edge [m]."""
    evidence_sd: float
    """Standard deviation of a range where a pose is judged, not found [m]."""

    def match(self, pose: Pose2, rays: Array, information: Array | None = None) -> Match:
        """Move a pose to where rays (n, 6) fit.

        Args:
            pose: the robot in the map, supposed.
            rays: as ``rays_of`` makes them.
            information: (3, 3) inverse covariance of the supposed pose; by default none, and the
                pose stays along what the rays say nothing of.
        """
        known = np.zeros((3, 3)) if information is None else information
        found, total, used = fit_rays(
            pose.to_array(), known, rays, self.index, self.range_max, self.sd, self.gate, STEPS
        )
        return Match(Pose2(*found.tolist()), total, used)

    def log_likelihood(self, pose: Pose2, rays: Array) -> float:
        """How well rays (n, 6) fit at a pose, on average of all rays."""
        return ray_log_likelihood(
            pose.to_array(), rays, self.index, self.sharp, self.range_max, self.evidence_sd
        )

    def relive(self, start: Pose2, past: Past) -> Life:
        """Follow a stretch of the way again, from a pose at its first scan.

        Args:
            start: the robot at the first scan, about.
            past: the scans, and how the robot moved between them.
        """
        pose, information, fits = relive(
            start.to_array(),
            past.start_information,
            past.moves,
            past.noise,
            past.rays,
            self.index,
            self.sharp,
            self.range_max,
            self.sd,
            self.gate,
            self.evidence_sd,
        )
        return Life(Pose2(*pose.tolist()), information, fits)


@njit(cache=True, nogil=True)
def relive(
    start: Array,
    known: Array,
    moves: Array,
    noise: Array,
    rays: Array,
    index: EdgeIndex,
    sharp: NDArray[np.bool_],
    range_max: float,
    sd: float,
    gate: float,
    evidence_sd: float,
) -> tuple[Array, Array, Array]:
    """An extended Kalman filter over scans, back in time: its first pose, and how each scan fit.

    Args:
        start: pose (3,) at the first scan.
        known: its information (3, 3).
        moves: (m, 3) the step before each scan, seen from its start; the first does not count.
        noise: (m, 3, 3) covariance of each step, seen from its start.
        rays: (m, k, 6) of each scan.
        index: the field's edges.
        range_max: how far rays reach [m].
        sd: standard deviation of a range [m].
        gate: ranges that are farther off do not measure an edge [m].
        evidence_sd: standard deviation of a range where the fit is judged [m].
    """
    pose, information = start.copy(), known.copy()
    fits = np.empty(len(moves))
    for k in range(len(moves)):
        if k > 0:
            pose, information = _moved(pose, information, moves[k], noise[k])
        pose, information, _ = fit_rays(
            pose, information, rays[k], index, range_max, sd, gate, STEPS
        )
        fits[k] = ray_log_likelihood(pose, rays[k], index, sharp, range_max, evidence_sd)
        if k == 0:
            newest, newest_information = pose.copy(), information.copy()
    return newest, newest_information, fits


@njit(cache=True, nogil=True)
def _moved(pose: Array, information: Array, move: Array, noise: Array) -> tuple[Array, Array]:
    """Pose and information after a step: G Sigma G^T + V M V^T."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = c * move[0] - s * move[1], s * move[0] + c * move[1]
    G = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
    V = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    covariance = G @ np.linalg.inv(information) @ G.T + V @ np.ascontiguousarray(noise) @ V.T
    return pose + np.array([dx, dy, move[2]]), np.linalg.inv(covariance)


@njit(cache=True, nogil=True)
def fit_rays(
    start: Array,
    known: Array,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    sd: float,
    gate: float,
    steps: int,
) -> tuple[Array, Array, int]:
    """Lay rays on the edges of the map by Gauss-Newton steps.

    Each ray is cast from the pose that is supposed; what it should have measured, what it did, and
    how the difference changes with the pose give one equation of a least-squares problem. Casting
    also says which edge it met: one that faces it, and none that is hidden.

    Args:
        start: the supposed pose (3,).
        known: its information (3, 3), the inverse of its covariance; zeros if nothing is known.
        rays: (n, 6) as ``rays_of`` makes them.
        index: the field's edges.
        range_max: how far rays reach [m].
        sd: standard deviation of a range [m].
        gate: ranges that are farther off than this do not measure the edge [m].
        steps: how often to linearise, at most.

    Returns:
        The pose (3,) that fits, its information (3, 3), and how many rays fit.
    """
    pose = start.copy()
    total = known.copy()
    used = 0
    for _ in range(steps):
        total[:] = known
        off = start - pose
        off[2] = (off[2] + math.pi) % (2 * math.pi) - math.pi
        pull = known @ off
        used = _add_rays(pose, rays, index, range_max, sd, gate, total, pull)
        # Along what nothing is known of, the pose stays.
        step = np.linalg.solve(total + 1e-3 * np.eye(3), pull)
        pose += step
        pose[2] = (pose[2] + math.pi) % (2 * math.pi) - math.pi
        if np.abs(step).max() < 1e-6:
            break
    return pose, total, used


@njit(cache=True, nogil=True)
def _add_rays(
    pose: Array,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    sd: float,
    gate: float,
    total: Array,
    pull: Array,
) -> int:
    """Add J^T W J and J^T W r of all rays that fit; returns their number."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    used = 0
    for i in range(len(rays)):
        # Where the ray starts, which moves when the robot turns.
        ahead = c * rays[i, 0] - s * rays[i, 1]
        aside = s * rays[i, 0] + c * rays[i, 1]
        heading = pose[2] + rays[i, 2]
        dx, dy = math.cos(heading), math.sin(heading)
        near = rays[i, 4]
        x, y = pose[0] + ahead + near * dx, pose[1] + aside + near * dy
        expected, edge = cast_toward(x, y, dx, dy, index, range_max - near)
        expected += near
        if edge < 0 or not abs(rays[i, 3] - expected) <= gate:
            continue
        ex = index.edges[edge, 2] - index.edges[edge, 0]
        ey = index.edges[edge, 3] - index.edges[edge, 1]
        across = dx * ey - dy * ex
        # How the range to the edge's line changes with x, y and theta.
        by_x, by_y = -ey / across, ex / across
        by_theta = expected * (dx * ex + dy * ey) / across - aside * by_x + ahead * by_y
        # It is the end's distance from the edge that errs evenly: a ray that grazes says less.
        weight = across * across / ((ex * ex + ey * ey) * sd * sd)
        _add_outer(total, weight, by_x, by_y, by_theta)
        residual = weight * (rays[i, 3] - expected)
        pull[0] += residual * by_x
        pull[1] += residual * by_y
        pull[2] += residual * by_theta
        used += 1
    return used


@njit(cache=True, nogil=True, inline="always")
def _add_outer(total: Array, weight: float, a: float, b: float, c: float) -> None:
    total[0, 0] += weight * a * a
    total[1, 1] += weight * b * b
    total[2, 2] += weight * c * c
    total[0, 1] += weight * a * b
    total[1, 0] += weight * a * b
    total[0, 2] += weight * a * c
    total[2, 0] += weight * a * c
    total[1, 2] += weight * b * c
    total[2, 1] += weight * b * c


@njit(cache=True, nogil=True)
def ray_log_likelihood(
    pose: Array,
    rays: Array,
    index: EdgeIndex,
    sharp: NDArray[np.bool_],
    range_max: float,
    sd: float,
) -> float:
    """How well rays (n, 6) fit a pose (3,): log-likelihood per ray, hits and misses alike.

    A mixture as in Probabilistic Robotics, Table 6.1, for a scanner that sometimes misses an edge
    (3 %) or sees one where none is (5 %). An edge that should be seen and is not is evidence, too.
    """
    c, s = math.cos(pose[2]), math.sin(pose[2])
    peak = 0.85 / (sd * math.sqrt(2 * math.pi))
    total = 0.0
    for i in range(len(rays)):
        heading = pose[2] + rays[i, 2]
        dx, dy = math.cos(heading), math.sin(heading)
        near, far = rays[i, 4], min(rays[i, 5], range_max)
        x = pose[0] + c * rays[i, 0] - s * rays[i, 1] + near * dx
        y = pose[1] + s * rays[i, 0] + c * rays[i, 1] + near * dy
        expected, edge = cast_toward(x, y, dx, dy, index, far - near)
        ended, across = False, 1.0
        if edge >= 0:
            ended, across = _met(x, y, dx, dy, expected, edge, index.edges, sharp)
        expected += near
        if math.isfinite(rays[i, 3]):
            fit = 0.05 / range_max
            if edge >= 0:
                off = (rays[i, 3] - expected) / sd
                fit = peak * math.exp(-0.5 * off * off) + 0.12 / range_max
            if ended:
                # Tape that is seen from its end may be seen through.
                ahead = expected - near + 0.005
                beyond, edge = cast_toward(
                    x + ahead * dx, y + ahead * dy, dx, dy, index, far - expected
                )
                if edge >= 0:
                    off = (rays[i, 3] - expected - 0.005 - beyond) / sd
                    fit = max(fit, peak * math.exp(-0.5 * off * off) + 0.12 / range_max)
            total += math.log(fit)
        elif edge >= 0 and not ended and near + NEAR < expected < far - FAR / across:
            total += math.log(0.03)
    return total / len(rays)


@njit(cache=True, nogil=True, inline="always")
def _met(
    x: float,
    y: float,
    dx: float,
    dy: float,
    distance: float,
    edge: int,
    edges: Array,
    sharp: NDArray[np.bool_],
) -> tuple[bool, float]:
    """Whether a ray meets an edge close to where it ends, and the sine of the angle."""
    ex, ey = edges[edge, 2] - edges[edge, 0], edges[edge, 3] - edges[edge, 1]
    length = math.hypot(ex, ey)
    from_start = (x + distance * dx - edges[edge, 0]) * ex + (
        y + distance * dy - edges[edge, 1]
    ) * ey
    along = from_start / length
    ended = (sharp[edge, 0] and along < END) or (sharp[edge, 1] and length - along < END)
    return ended, abs(dx * ey - dy * ex) / length


def sharp_ends(edges: Array) -> NDArray[np.bool_]:
    """Whether the edge (n, 4) turns sharply, or ends, at its start and at its end (n, 2)."""
    heading = np.arctan2(edges[:, 3] - edges[:, 1], edges[:, 2] - edges[:, 0])
    starts = {tuple(np.round(edge[:2], 6)): i for i, edge in enumerate(edges)}
    sharp = np.ones((len(edges), 2), dtype=bool)
    for i, edge in enumerate(edges):
        after = starts.get(tuple(np.round(edge[2:], 6)))
        if after is not None:
            turn = abs(math.remainder(heading[after] - heading[i], 2 * math.pi))
            sharp[i, 1] = sharp[after, 0] = turn > 0.3
    return sharp
