"""The table knows how far it is to the nearest edge that a ray can enter, near edges exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from places import MAPS

from robot.fields.edges import outline
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.floor_picture import FloorPicture
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.models.entry_field import DIRECTIONS, MOST_CELLS, EntryField
from robot.scanning.tape import Tape

FARTHEST = 0.15


def field_of(*areas: shapely.Geometry, turned: float = 0.0, half: float = 3.0) -> Field:
    """Tape of given areas [m], turned about the origin."""
    turn = Pose2(0, 0, turned)
    edges = outline(shapely.union_all(areas)).reshape(-1, 2)
    side = round(2 * half * 20)
    floor = FloorPicture(np.full((side, side), 255, np.uint8), 0.05, (-half, -half, half, half))
    return Field("test", floor, turn.apply(edges).reshape(-1, 4), (Tape(0.05),), Pose2())


WALL = shapely.box(0.475, -1.0, 0.525, 1.0)
"""Tape across the x axis: rays along +x enter at 0.475 m."""


def table_of(field: Field, resolution: float = 0.005) -> EntryField:
    return EntryField.build(field, resolution=resolution, max_distance=FARTHEST)


def look_up(table: EntryField, points: Array, headings: Array) -> Array:
    """Bilinear, without the sign where the corners of a cell differ by more than the way."""
    column, row = ((points - table.origin) / table.resolution).T
    c, r = np.floor(column).astype(int), np.floor(row).astype(int)
    direction = np.round(headings * DIRECTIONS / (2 * math.pi)).astype(int) % DIRECTIONS
    corners = np.array([table.distances[direction, r + j, c + i] for j in (0, 1) for i in (0, 1)])
    jumps = np.ptp(corners, axis=0) > 1.5 * table.resolution
    corners = np.where(jumps, np.abs(corners), corners)
    u, v = column - c, row - r
    parts = np.array([(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u])
    return np.abs((parts * corners).sum(axis=0))


def across_wall(depths: Array, turned: float) -> Array:
    """Points at depths [m] behind the wall's entry edge, at many places along it."""
    along = np.linspace(-0.8, 0.8, len(depths))
    return Pose2(0, 0, turned).apply(np.column_stack([0.475 + depths, along]))


@pytest.mark.slow
@pytest.mark.parametrize("turned", [0.0, 0.1, math.radians(30), 2.0, -2.9])
def test_it_is_exact_before_on_and_behind_a_straight_edge(turned: float) -> None:
    """From 60 mm before to 40 mm behind: also where the sign ends, 10 mm behind the edge."""
    table = table_of(field_of(WALL, turned=turned))
    depths = np.random.default_rng(0).uniform(-0.06, 0.04, 4000)
    found = look_up(table, across_wall(depths, turned), np.full(4000, turned))
    np.testing.assert_allclose(found, np.abs(depths), atol=0.05e-3)


def test_deeper_in_the_tape_is_never_nearer_to_its_edge() -> None:
    """No ghost of the edge anywhere behind it."""
    table = table_of(field_of(WALL))
    depths = np.linspace(0, 0.12, 1000)
    points = np.column_stack([0.475 + depths, np.full(1000, 0.1234)])
    assert (np.diff(look_up(table, points, np.zeros(1000))) > -1e-6).all()


def test_the_far_side_of_tape_does_not_attract_a_ray() -> None:
    """The edge that a ray leaves by is 50 mm from the one it enters by."""
    table = table_of(field_of(WALL))
    exit_side = np.array([[0.525, 0.0], [0.525, 0.3]])
    np.testing.assert_allclose(look_up(table, exit_side, np.zeros(2)), 0.050, atol=1e-4)
    np.testing.assert_allclose(look_up(table, exit_side, np.full(2, math.pi)), 0.0, atol=1e-4)
    np.testing.assert_allclose(look_up(table, exit_side - (0.05, 0), np.full(2, math.pi)), 0.05,
                               atol=1e-4)  # fmt: skip


@pytest.mark.parametrize("heading", np.radians([-66, -40, -20, 0, 22, 45, 66]))
def test_a_ray_in_any_direction_finds_the_edge_that_it_meets(heading: float) -> None:
    table = table_of(field_of(WALL))
    y = np.linspace(-0.5, 0.5, 50)
    ends = np.column_stack([np.full(50, 0.475), y])
    np.testing.assert_allclose(look_up(table, ends, np.full(50, heading)), 0, atol=0.05e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["square", "stub", "town"])
def test_the_end_of_every_exact_ray_lies_on_an_edge(name: str) -> None:
    """Whatever the direction: also where a ray all but runs along the tape."""
    field = load_field(name, MAPS)
    table = table_of(field)
    poses = field.free_poses(np.random.default_rng(0), 300)
    bearings = np.linspace(-math.pi, math.pi, 60)
    ranges = np.empty((300, 60))
    cast_rays(poses, bearings, field.edge_index, 1.0, ranges)
    headings = poses[:, 2:] + bearings
    hit = np.isfinite(ranges)
    ends = poses[:, None, :2] + ranges[..., None] * heading_vectors(headings)
    found = look_up(table, ends[hit], headings[hit])
    assert np.mean(found > 0.001) < 0.002
    assert np.mean(found) < 0.1e-3


def test_far_from_any_edge_it_is_the_greatest_distance() -> None:
    table = table_of(field_of(WALL))
    far = np.array([[0.475 - FARTHEST, 0.0], [0.475 - FARTHEST + 0.004, 0.9]])
    np.testing.assert_allclose(look_up(table, far, np.zeros(2)), [0.15, 0.146], atol=1e-3)
    assert np.abs(table.distances).max() <= np.float32(FARTHEST)
    assert (table.distances[:, [0, -1]] == np.float32(FARTHEST)).all(), "and so it is at the rim"


def test_a_direction_in_which_nothing_can_be_met_is_far_from_everything() -> None:
    """Light on one side of a long edge only, seen from behind."""
    one_sided = field_of(WALL)
    edges = one_sided.edges[one_sided.normals[:, 0] < -0.9]
    table = table_of(Field("one", one_sided.floor, edges, (), Pose2()))
    assert (table.distances[DIRECTIONS // 2] == np.float32(FARTHEST)).all()
    assert (table.distances[0] < np.float32(FARTHEST)).any()


def test_past_the_end_of_an_edge_it_is_the_way_to_the_end() -> None:
    table = table_of(field_of(WALL))
    beyond = np.array([[0.475, 1.03], [0.445, 1.04], [0.475, -1.1]])
    found = look_up(table, beyond, np.zeros(3))
    np.testing.assert_allclose(found, [0.03, 0.05, 0.1], atol=0.5e-3)


def test_the_table_covers_what_is_near_enough_to_count() -> None:
    field = field_of(WALL)
    table = table_of(field)
    _, height, width = table.distances.shape
    points = field.edges.reshape(-1, 2)
    low, size = np.array(table.origin), table.resolution * np.array([width - 1, height - 1])
    assert (low <= points.min(axis=0) - FARTHEST + 1e-9).all()
    assert (low + size >= points.max(axis=0) + FARTHEST - 1e-9).all()
    assert table.distances.dtype == np.float32


@pytest.mark.slow
def test_a_large_field_gets_coarser_cells_and_is_still_exact_near_its_edges() -> None:
    """100 m by 100 m: tables of 5 mm cells would take 13 GB."""
    walls = [shapely.box(-50, -50, 50, -49), shapely.box(49, -50, 50, 50)]
    table = EntryField.build(
        field_of(*walls, half=60.0), resolution=0.005, max_distance=2.0
    )  # fmt: skip
    assert table.distances[0].size < 1.1 * MOST_CELLS
    assert table.resolution > table.wanted_resolution == 0.005
    depths = np.random.default_rng(0).uniform(-0.3, 0.3, 500)
    points = np.column_stack([49.0 + depths, np.linspace(-30, 30, 500)])
    np.testing.assert_allclose(look_up(table, points, np.zeros(500)), np.abs(depths), atol=2e-3)
