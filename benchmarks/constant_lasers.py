"""Trials of a constant of maps that are drawn from a laser's scans: laps in a building.

The wheels drift, so that a loop has to be closed. A pose graph draws the walls, and particles do.
"""

from __future__ import annotations

import math
import pickle
import zlib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from app.features.lab.localize.laser_map import LaserMap
from robot.fields.occupancy_grid import OccupancyGrid
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2
from robot.mapping.graph.graph_slam import GraphSettings, GraphSlam
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cell_mapper import CellMapper
from robot.mapping.grid.fast_slam import WALLS, FastSlam
from robot.scan import Scan

CELL, WIDTH, HEIGHT = 0.05, 240, 180
"""Of the building [m], in cells."""
BLOCKS = ((50, 130, 60, 180), (28, 40, 30, 36), (150, 156, 100, 130), (80, 90, 220, 228))
"""What stands in it: first and last row and column."""
SEEDS = (60300, 60301)
LOOKS, TURN = 72, 2.3 * math.pi
"""Scans of a drive, and how far around the building it goes [rad]."""
AROUND = (4.6, 3.2)
"""Half the drive's length and width [m]."""
BEARINGS = np.radians(np.arange(-120, 120, 1.5))
REACH = 12.0
NOISE, SHORT = 0.02, 0.04
"""Noise of a range [m], and the share of rays that meet people."""
SCALE, WHEELS = (1.03, 1.04), 0.04
"""How far wheels lead off, in way and turn, and the noise of both as a share of the way."""


@dataclass(frozen=True, eq=False)
class LaserLap:
    """What a robot measures, and the truth."""

    truth: list[Pose2]
    steps: list[Pose2]
    scans: list[Scan]
    walls: Array
    """(n, 2) middles of occupied cells [m]"""
    seed: int


def recorded(kept: Path | None) -> list[LaserLap]:
    """Return all laps; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        laps: list[LaserLap] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return laps
    laps = [lap(seed) for seed in SEEDS]
    if kept is not None:
        kept.write_bytes(pickle.dumps(laps))
    return laps


def few(laps: list[LaserLap]) -> list[LaserLap]:
    """Return all: they are few."""
    return laps


def lap(seed: int) -> LaserLap:
    """Drive around the building's middle."""
    cells = np.zeros((HEIGHT, WIDTH), np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    for top, bottom, left, right in BLOCKS:
        cells[top:bottom, left:right] = 100
    building = LaserMap.of(OccupancyGrid(cells, CELL, Pose2()), "building")
    rng = np.random.default_rng(seed)
    middle = CELL * WIDTH / 2, CELL * HEIGHT / 2
    truth = [
        Pose2(
            middle[0] + AROUND[0] * math.sin(turn),
            middle[1] - AROUND[1] * math.cos(turn),
            math.atan2(AROUND[1] * math.sin(turn), AROUND[0] * math.cos(turn)),
        )
        for turn in np.linspace(0, TURN, LOOKS)
    ]
    steps = [Pose2()]
    for before, after in pairwise(truth):
        moved = before.inverse() @ after
        way = math.hypot(moved.x, moved.y)
        noise = rng.normal(0, WHEELS * way, 2)
        steps.append(
            Pose2(SCALE[0] * moved.x + noise[0], moved.y, SCALE[1] * moved.theta + noise[1])
        )
    exact, scans = np.empty((1, len(BEARINGS))), []
    for number, pose in enumerate(truth):
        cast_rays(pose.to_array()[None], BEARINGS, building.field.edge_index, REACH, exact)
        ranges = exact[0] + rng.normal(0, NOISE, exact.size)
        met = rng.random(exact.size) < SHORT
        ranges = np.where(met, ranges * rng.random(exact.size), ranges)
        scans.append(Scan(0.5 * number, BEARINGS, ranges))
    walls = CELL * (np.argwhere(cells)[:, ::-1].astype(float) + 0.5)
    return LaserLap(truth, steps, scans, walls, seed)


def tried(laps: list[LaserLap], other_numbers: int) -> dict[str, Any]:
    """Draw all walls in both ways; return figures by name, and a number for each result.

    Args:
        other_numbers: if not 0, added to the seeds of other laps.
    """
    if other_numbers:
        laps = [lap(each.seed + other_numbers) for each in laps]
    figures: dict[str, Any] = {}
    each = []
    for name in ("graph", "particles"):
        drawn = [_drawn(name, driven) for driven in laps]
        rows = np.array(
            [_figures(mapper, driven) for mapper, driven in zip(drawn, laps, strict=True)]
        )
        figures |= {
            f"{name}: path off [mm]": float(rows[:, 0].mean()),
            f"{name}: at most [mm]": float(rows[:, 1].max()),
            f"{name}: walls off [mm]": float(rows[:, 2].mean()),
        }
        each += [zlib.crc32(mapper.path.tobytes() + mapper.grid.data.tobytes()) for mapper in drawn]
    return figures | {"each": each}


def _drawn(name: str, driven: LaserLap) -> CellMapper:
    if name == "graph":
        mapper: CellMapper = GraphSlam(GraphSettings(), driven.truth[0])
    else:
        mapper = FastSlam(WALLS, driven.truth[0], np.random.default_rng(driven.seed))
    for step, scan in zip(driven.steps, driven.scans, strict=True):
        mapper.update(step, Beams.of_scan(scan, REACH))
    mapper.finish()
    return mapper


def _figures(mapper: CellMapper, driven: LaserLap) -> tuple[float, float, float]:
    """Return the path's error and the largest, and that of drawn walls [mm]."""
    true = np.array([(pose.x, pose.y) for pose in driven.truth])
    errors = np.hypot(*(mapper.path[:, :2] - true).T)
    places = np.argwhere(mapper.grid.occupied)[:, ::-1].astype(float) + 0.5
    drawn = mapper.grid.origin.apply(places * mapper.grid.resolution)
    away = np.asarray(cKDTree(driven.walls).query(drawn)[0])
    return (
        1e3 * float(np.sqrt(np.mean(errors**2))),
        1e3 * float(errors.max()),
        1e3 * float(np.mean(away)) if len(away) else math.inf,
    )
