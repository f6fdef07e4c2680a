"""Which edges the line scanner sees: its own judgement, asked of the map."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from tape_trials import MAPS, SCANNER, SQUARE, STILL, camera_of

from robot.fields.edges import lengths, outline, sharp_ends
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.grid_field import field_from_grid
from robot.fields.occupancy_grid import OccupancyGrid
from robot.fields.visibility import STEP, Visibility, visibility
from robot.geometry import Array, Pose2
from robot.interface import Frame
from robot.localization.ray_evidence import RayEvidence
from robot.scan import rays_of
from robot.scanning.line_scanner import LineScannerSettings
from robot.scanning.tape import Tape

WIDTH = 0.05
TAPE = (Tape(WIDTH),)
SUPPORT = LineScannerSettings().support


def middles(edges: Array, sight: Visibility) -> Array:
    """The middle (m, 2) of each part."""
    found = []
    for edge, (first, last) in enumerate(zip(sight.starts[:-1], sight.starts[1:], strict=True)):
        share = ((np.arange(last - first) + 0.5) / (last - first))[:, None]
        found.append(edges[edge, :2] * (1 - share) + edges[edge, 2:] * share)
    return np.vstack(found)


def ring(radius: float) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Edges of a circle of tape, which parts lie outside, and which are seen."""
    line = shapely.Point(0, 0).buffer(radius, quad_segs=64).exterior
    edges = outline(line.buffer(WIDTH / 2, quad_segs=64))
    sight = visibility(edges, TAPE)
    outside = np.hypot(*middles(edges, sight).T) > radius
    return edges, outside, sight.seen


def test_edges_are_cut_into_equal_parts_of_some_millimetres() -> None:
    for name in ("stub", "town"):
        edges = load_field(name, MAPS).edges
        sight = visibility(edges, TAPE)
        counts = np.diff(sight.starts)
        assert len(sight.seen) == sight.starts[-1] and counts.min() >= 1
        assert (lengths(edges) / counts <= STEP + 1e-9).all()
        np.testing.assert_array_equal(sight.ends, sharp_ends(edges))


def test_on_a_square_all_but_the_corners_is_seen() -> None:
    sight = SQUARE.visibility
    places = np.abs(middles(SQUARE.edges, sight))
    inner = places.max(axis=1) < 0.5
    from_corner = np.where(inner, 0.475, 0.525) - places.min(axis=1)
    assert inner.sum() == 4 * 190
    assert sight.seen[inner & (from_corner > SUPPORT)].all()
    assert sight.seen[~inner & (from_corner > WIDTH + SUPPORT)].all()
    # Seen straight on, what lies behind a corner's outer edge is the length of another tape.
    assert not sight.seen[~inner & (from_corner < 0.8 * WIDTH)].any()


def test_the_sides_of_a_stub_are_seen_and_its_end_is_not() -> None:
    field = load_field("stub", MAPS)
    sight = field.visibility
    x, y = middles(field.edges, sight).T
    end = np.abs(x - 0.175) < 1e-6
    side = (np.abs(np.abs(y) - 0.025) < 1e-6) & (x > 0.175) & (x < 0.474)
    assert end.sum() == 10 and not sight.seen[end].any()
    assert sight.seen[side & (x > 0.175 + SUPPORT) & (x < 0.475 - SUPPORT)].all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius", "inside", "outside"), [(0.1, True, True), (0.25, True, True), (0.04, False, False)]
)
def test_a_circle_of_tape_is_seen_unless_it_bends_too_tightly(
    radius: float, inside: bool, outside: bool
) -> None:
    _, beyond, seen = ring(radius)
    assert 0 < beyond.sum() < len(beyond)
    assert seen[~beyond].mean() == inside
    assert seen[beyond].mean() == outside


def test_tape_of_another_width_is_not_seen() -> None:
    assert not visibility(SQUARE.edges, (Tape(0.08),)).seen.any()
    assert not visibility(SQUARE.edges, (Tape(0.03),)).seen.any()


def test_where_only_straight_tape_counts_a_bend_is_blind() -> None:
    edges, _, seen = ring(0.1)
    strict = visibility(edges, TAPE, LineScannerSettings(bend_radius=1000.0, straightness=0.001))
    assert seen.all() and not strict.seen.any()


def test_walls_are_all_seen() -> None:
    """Of a ROS map, for a laser."""
    cells = np.full((9, 11), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    field = field_from_grid(OccupancyGrid(cells, 0.1, Pose2()), "room")
    assert field.tape_width is None
    sight = field.visibility
    assert sight.seen.all() and len(sight.seen) == len(field.edges)
    np.testing.assert_array_equal(sight.starts, np.arange(len(field.edges) + 1))


def missed(field: Field, count: int) -> tuple[int, int]:
    """How many rays at true poses are due, and how many of these return nothing."""
    camera, evidence = camera_of(field), RayEvidence.of(field, 1.0, 0.005)
    due = lost = 0
    for values in field.free_poses(np.random.default_rng(0), count):
        pose = Pose2.from_array(values)
        rays = rays_of(SCANNER.scan(Frame(0.0, camera.picture(pose, STILL))).scan, 91)
        nothing = rays.copy()
        nothing[:, 3], nothing[:, 6] = math.inf, 1.0
        whole = evidence.log_likelihood(pose, nothing)
        for place, ray in enumerate(rays):
            # What is due costs less where the picture is not clear.
            unclear = nothing.copy()
            unclear[place, 6] = 0.0
            if evidence.log_likelihood(pose, unclear) != whole:
                due += 1
                lost += math.isinf(ray[3])
    return due, lost


@pytest.mark.parametrize("name", ["square", "town", "generated-3", "generated-8", "generated-21"])
def test_what_should_be_seen_is(name: str) -> None:
    """One question, one answer: what the evidence counts as due, the scanner returns."""
    due, lost = missed(load_field(name, MAPS), 30)
    assert due > 300
    assert lost <= 0.03 * due
