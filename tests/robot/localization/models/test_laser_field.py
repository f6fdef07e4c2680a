"""The tables of a laser's map, and how a scan is weighed by them."""

import math

import numpy as np
import pytest
from entry_reading import distance_at

from app.features.lab.localize.laser_map import FreeWay, free_field, wall_field
from robot.fields.field import FieldError
from robot.fields.grid_field import field_from_grid
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2
from robot.localization.kernels.entry_planes import ROWS, planes
from robot.localization.models.entry_field import DIRECTIONS, EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.scan import Scan

CELL = 0.1
FARTHEST = 1.0


def grid(cells, origin=Pose2(-1.0, 2.0)):
    return OccupancyGrid(np.asarray(cells, dtype=np.int8), CELL, origin)


def walled(seed=0, shape=(60, 90)):
    rng = np.random.default_rng(seed)
    return grid(rng.choice([0, 0, 0, 0, 0, 0, 0, 0, 100, -1], shape))


def looked_up(table, points):
    column, row = ((points - table.origin) / table.resolution).T
    at = np.zeros(len(points)), row, column
    return distance_at(table.planes, table.resolution, table.max_distance, at)


@pytest.mark.parametrize(("build", "chosen"), [(wall_field, "occupied"), (free_field, "free")])
def test_distances_are_those_from_the_middles_of_cells(build, chosen):
    on = walled()
    table = build(on, FARTHEST)
    rows, columns = np.nonzero(getattr(on, chosen))
    middles = np.column_stack([columns + 0.5, rows + 0.5]) * CELL + (on.origin.x, on.origin.y)
    asked = np.random.default_rng(1).integers(0, (90, 60), (500, 2))
    points = (asked + 0.5) * CELL + (on.origin.x, on.origin.y)
    nearest = np.hypot(*(points[:, None] - middles).transpose(2, 0, 1)).min(axis=1)
    exact = np.minimum(nearest, FARTHEST)
    column, row = np.rint((points - table.origin) / CELL).astype(int).T
    assert table.distances[0, row, column] == pytest.approx(exact, abs=1e-4)
    # Where distances bend, as at a single cell, a plane is off by up to half a cell.
    assert looked_up(table, points + 1e-9) == pytest.approx(exact, abs=0.51 * CELL)


def test_beyond_the_rim_distances_grow_until_they_are_the_greatest():
    cells = np.zeros((5, 5))
    cells[:, 4] = 100
    table = wall_field(grid(cells, Pose2()), FARTHEST)
    points = np.array([[0.45 + far, 0.2] for far in (0.0, 0.3, 0.65, 0.95, 3.0)])
    assert table.distances.shape[2] > (0.45 + 0.95 - table.origin[0]) / CELL
    assert looked_up(table, points[:4]) == pytest.approx([0.0, 0.3, 0.65, 0.95], abs=2e-3)


def test_a_map_without_walls_or_turned_is_refused():
    with pytest.raises(FieldError, match="no occupied cell"):
        wall_field(grid(np.zeros((4, 4))), FARTHEST)
    with pytest.raises(FieldError, match="no free cell"):
        free_field(grid(np.full((4, 4), 100)), FARTHEST)
    with pytest.raises(FieldError, match="turned by 1 rad"):
        wall_field(grid(np.full((4, 4), 100), Pose2(0, 0, 1)), FARTHEST)


def test_a_tall_table_is_the_same_as_its_pieces():
    """It is made some rows at a time."""
    rng = np.random.default_rng(2)
    tall = rng.uniform(-0.1, 0.1, (2, 3 * ROWS + 7, 9)).astype(np.float32)
    whole = planes(tall, 0.005, 0.15)
    for start in (0, 10, ROWS - 1, 2 * ROWS + 3):
        piece = planes(tall[:, start : start + ROWS // 2], 0.005, 0.15)
        assert (whole[:, start : start + ROWS // 2 - 1] == piece[:, :-1]).all()


def scan_of(rng, count=80):
    bearings = np.linspace(-2, 2, count)
    ranges = np.where(rng.random(count) < 0.1, np.inf, rng.uniform(0.3, 6, count))
    return Scan(0.0, bearings, ranges, Pose2(0.2, 0.1, 0.3))


@pytest.mark.parametrize("skips", [None, False, True])
def test_one_table_for_all_directions_is_as_eight_alike(skips):
    one = wall_field(walled(), FARTHEST)
    eight = EntryField(
        np.repeat(one.distances, DIRECTIONS, axis=0), one.origin, CELL, FARTHEST, CELL
    )
    rng = np.random.default_rng(3)
    poses = rng.uniform((-2, 1, -9), (9, 9, 9), (700, 3))
    if skips:  # which is not done while a cloud is wide
        poses = (2.0, 5.0, 0.5) + 0.01 * rng.standard_normal((700, 3))
    scan, found = scan_of(rng), []
    for table in (one, eight):
        model = LikelihoodField(table, 0.1, 0.9, 0.1, 30.0, 60)
        if skips is not None:
            model = LikelihoodFieldProb(model, skips, 0.3, 0.3, 0.9)
        found.append(model.log_likelihood(poses, scan))
    assert (found[0] == found[1]).all()


def room():
    """6 m x 4 m with a wall across; free all around as well, as where a map was drawn too large."""
    cells = np.zeros((60, 80))
    cells[[10, 50], 10:71] = 100
    cells[10:51, [10, 40, 70]] = 100
    return grid(cells, Pose2())


def test_a_ray_that_runs_through_a_wall_counts_against_a_pose():
    on = room()
    plain = LikelihoodField(wall_field(on, FARTHEST), 0.1, 0.9, 0.1, 30.0, 60)
    ways = LikelihoodField(free_field(on, FARTHEST), 0.1, 1.0, 0.1, 1.0, 60)
    seeing = FreeWay(plain, ways, 1.0, 0.3)
    # From x = 2 the wall at 4.05 is 2.05 m ahead; the next is 5.05 m ahead, behind it.
    bearings = np.zeros(5)
    poses = np.array([[2.0, 3.0, 0.0]])
    near, far = (Scan(0.0, bearings, np.full(5, r)) for r in (2.05, 5.05))
    found, same = (plain.log_likelihood(poses, scan) for scan in (near, far))
    assert found == pytest.approx(same, abs=0.1)
    free = 5 * math.log(1.1)  # of five places on the way
    assert seeing.log_likelihood(poses, near) - found == pytest.approx(free, abs=0.05)
    # The place at half of the way, 0.3 m of it left out, is in the wall.
    through = Scan(0.0, bearings, np.full(5, 0.3 + 2.05 / 0.5))
    ends, both = (model.log_likelihood(poses, through)[0] for model in (plain, seeing))
    assert both - ends < free - 0.1
    assert seeing.count_rays(poses, near) == 5


def test_rays_shorter_than_the_margin_and_those_without_return_are_not_looked_at():
    on = room()
    plain = LikelihoodField(wall_field(on, FARTHEST), 0.1, 0.9, 0.1, 30.0, 60)
    ways = LikelihoodField(free_field(on, FARTHEST), 0.1, 1.0, 0.1, 1.0, 60)
    scan = Scan(0.0, np.zeros(4), np.array([0.1, 0.2, np.inf, 0.29]))
    poses = np.array([[4.05, 3.0, 0.0], [2.0, 3.0, 1.0]])
    seeing = FreeWay(plain, ways, 1.0, 0.3)
    assert (seeing.log_likelihood(poses, scan) == plain.log_likelihood(poses, scan)).all()
    nothing = Scan(0.0, np.zeros(4), np.full(4, np.inf))
    assert (seeing.log_likelihood(poses, nothing) == 0).all()


def test_the_true_pose_is_the_likeliest():
    from robot.fields.ray_casting import cast_rays

    on = room()
    field = field_from_grid(on, "room")
    truth = Pose2(2.6, 2.1, 0.7)
    bearings = np.linspace(-math.pi, math.pi, 90, endpoint=False)
    ranges = np.empty((1, 90))
    cast_rays(truth.to_array()[None], bearings, field.edge_index, 20.0, ranges)
    scan = Scan(0.0, bearings, ranges[0])
    seeing = FreeWay(
        LikelihoodField(wall_field(on, FARTHEST), 0.1, 0.9, 0.1, 30.0, 90),
        LikelihoodField(free_field(on, FARTHEST), 0.1, 1.0, 0.1, 1.0, 90),
        0.5,
        0.3,
    )
    others = field.free_poses(np.random.default_rng(0), 3000)
    far = np.hypot(others[:, 0] - truth.x, others[:, 1] - truth.y) > 0.5
    best = seeing.log_likelihood(truth.to_array()[None], scan)[0]
    assert best > seeing.log_likelihood(others[far], scan).max()
