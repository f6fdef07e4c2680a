"""Measures how exact walls are that a laser's log becomes: ``laser_trials.py LOG``.

Not a test: each drive takes about a minute, with particles (``--method grid``) some minutes. The
log's odometry is taken as the true path (it has to be corrected, as that of the Intel lab is), and
noisy odometry is made of it. With ``--simulated`` the scans are cast in the building that the log
shows, so that the truth is known. Such a laser errs as real ones do, in one way all along the
drive: its ranges are off, it sits askew, and its scans come late; with ``--perfect`` it has noise
alone. The share of pairs of poses is told whose difference lies within its 95 % interval.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
from mappings import aligned
from scipy.spatial import cKDTree

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.reading.carmen import CarmenLog
from app.features.lab.mapping.looks import REACH_M
from robot.fields.ray_casting import cast_rays
from robot.geometry import Pose2
from robot.mapping.graph.graph_slam import GraphSettings, GraphSlam
from robot.mapping.graph.wall_drawing import WallDrawing
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cell_mapper import CellMapper
from robot.mapping.grid.fast_slam import WALLS, FastSlam
from robot.scan import Scan

NEAR_M = 0.1
RANGE_SD = 0.02
BIAS_M, MOUNTED, LATE = 0.015, (0.01, 0.01, 0.005), 0.02
"""Deviations of what a laser does wrong all along: of ranges, of where it sits [m, m, rad], and how
late its scans are, as a share of the steps."""
PAIRS, RELATIONS, CHI_SQUARE = 1000, 2000, 5.99
SCALE_SD = 0.02
"""Of wheels and track, for the whole drive."""
ALONG, ASIDE, TURN = 0.05, 0.02, (0.05, 0.02)
"""Noise of a step, as shares of its length; of its turn, and by its length [rad/m]."""


def noisy(moved: Pose2, scale: tuple[float, float], rng: np.random.Generator) -> Pose2:
    far = math.hypot(moved.x, moved.y)
    return Pose2(
        moved.x * scale[0] + rng.normal(0, ALONG * far),
        moved.y + rng.normal(0, ASIDE * far),
        moved.theta * scale[1] + rng.normal(0, TURN[0] * abs(moved.theta) + TURN[1] * far),
    )


def mapper(method: str, start: Pose2, rng: np.random.Generator) -> CellMapper:
    return GraphSlam(GraphSettings(), start) if method == "graph" else FastSlam(WALLS, start, rng)


def simulated(
    poses: tuple[Pose2, ...], scans: tuple[Scan, ...], seed: int, perfect: bool
) -> tuple[Scan, ...]:
    """What a laser would see in the building that its scans show."""
    path = np.array([pose.to_array() for pose in poses])
    drawn = WallDrawing.of(path, [Beams.of_scan(scan, REACH_M) for scan in scans], 0.05)
    building, rng = LaserMap.of(drawn.grid, "building"), np.random.default_rng(seed)
    cells_from_map = building.pose_in_map(Pose2()).inverse()
    wrong = 0.0 if perfect else 1.0
    bias, late = wrong * rng.normal(0, BIAS_M), wrong * rng.normal(0, LATE)
    askew = Pose2(*(wrong * rng.normal(0, MOUNTED)))
    exact, cast = np.empty((1, len(scans[0].bearings))), []
    for before, pose, scan in zip((poses[0], *poses), poses, scans, strict=False):
        step = before.inverse() @ pose
        seen_from = pose @ Pose2(late * step.x, late * step.y, late * step.theta)
        sensor = (cells_from_map @ seen_from @ askew @ scan.robot_from_scan).to_array()[None]
        cast_rays(sensor, scan.bearings, building.field.edge_index, REACH_M, exact)
        ranges = exact[0] + bias + rng.normal(0, RANGE_SD, exact.size)
        cast.append(replace(scan, ranges=ranges))
    return tuple(cast)


def held(slam: GraphSlam, poses: tuple[Pose2, ...]) -> float:
    """The share of pairs of poses whose difference lies within its 95 % interval."""
    graph = slam.graph
    pairs = np.random.default_rng(0).integers(0, len(poses), (PAIRS, 2)).tolist()
    inside = []
    for a, b in ((a, b) for a, b in pairs if a != b):
        true, drawn = poses[a].inverse() @ poses[b], graph.pose(a).inverse() @ graph.pose(b)
        off, covariance = true.offset_to(drawn)[:2], slam.covariance(b, a)[:2, :2]
        inside.append(off @ np.linalg.solve(covariance, off) < CHI_SQUARE)
    return float(np.mean(inside))


def relations(path: np.ndarray, true: np.ndarray) -> list[str]:
    """How far relations between poses are off (Kuemmerle et al. 2009): along the path, and loops.

    Along the path they lead 1 to 5 m on; at loops to poses within 3 m that were taken 15 m of
    driving later or more.
    """
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(true[:, :2], axis=0).T))])
    driven = way[None] - way[:, None]
    apart = np.hypot(*(true[None, :, :2] - true[:, None, :2]).transpose(2, 0, 1))
    near, again = (driven >= 1) & (driven <= 5), (driven > 15) & (apart < 3)
    rng, words = np.random.default_rng(0), []
    for begins, ends in (np.nonzero(near), np.nonzero(again)):
        if not len(begins):
            words.append("none")
            continue
        chosen = rng.integers(0, len(begins), RELATIONS)
        off = np.array(
            [
                (_pose(true, a).inverse() @ _pose(true, b)).offset_to(
                    _pose(path, a).inverse() @ _pose(path, b)
                )
                for a, b in zip(begins[chosen].tolist(), ends[chosen].tolist(), strict=True)
            ]
        )
        far, turned = np.hypot(off[:, 0], off[:, 1]), np.degrees(np.abs(off[:, 2]))
        words.append(
            f"{far.mean():.3f} +- {far.std():.3f} m, {turned.mean():.2f} +- {turned.std():.2f} deg"
        )
    return words


def _pose(path: np.ndarray, node: int) -> Pose2:
    return Pose2(*path[node].tolist())


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("log", type=Path, help="a CARMEN log with corrected odometry")
    parser.add_argument("--seeds", type=int, nargs=2, default=(100, 103), metavar=("A", "END"))
    parser.add_argument("--method", choices=("graph", "grid"), default="graph")
    parser.add_argument("--simulated", action="store_true", help="cast the scans anew")
    parser.add_argument("--perfect", action="store_true", help="by a laser that has noise alone")
    given = parser.parse_args()
    poses, scans = zip(*chain(*CarmenLog(given.log).drives()), strict=True)
    true = np.array([pose.to_array() for pose in poses])
    seen = [p.apply(s.within(0, REACH_M).points()) for p, s in zip(poses, scans, strict=True)]
    walls = cKDTree(np.vstack(seen))
    for seed in range(*given.seeds):
        rng = np.random.default_rng(seed)
        scale = 1 + SCALE_SD * rng.normal(), 1 + SCALE_SD * rng.normal()
        slam, odometry = mapper(given.method, poses[0], rng), [poses[0]]
        begun = time.process_time()
        made = simulated(poses, scans, seed, given.perfect) if given.simulated else scans
        for k, scan in enumerate(made):
            step = noisy(poses[k - 1].inverse() @ poses[k], scale, rng) if k else Pose2()
            slam.update(step, Beams.of_scan(scan, REACH_M))
            odometry.append(odometry[-1] @ step)
        slam.finish()
        taken = time.process_time() - begun
        by_wheels = np.array([pose.to_array() for pose in odometry[1:]])
        map_to_true = aligned(slam.path[:, :2], true[:, :2])
        distances, _ = walls.query(map_to_true.apply(slam.ends))
        print(
            f"seed {seed}: {100 * (distances < NEAR_M).mean():.1f} % of the walls within "
            f"{NEAR_M:g} m, path {rms(slam.path, true):.3f} m off "
            f"(odometry {rms(by_wheels, true):.2f} m), {taken:.0f} s of the processor",
            flush=True,
        )
        if isinstance(slam, GraphSlam):
            print(f"  {100 * held(slam, poses):.0f} % of the differences held", flush=True)
            along, loops = relations(slam.graph.poses, true)
            print(f"  relations along the path {along}, at loops {loops}", flush=True)


def rms(path: np.ndarray, true: np.ndarray) -> float:
    """Of the distances after alignment [m]."""
    off = aligned(path[:, :2], true[:, :2]).apply(path[:, :2]) - true[:, :2]
    return float(np.sqrt((off**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()
