"""Measures how exact walls are that a laser's log becomes: ``python tests/laser_trials.py LOG``.

Not a test: each drive takes about a minute, with particles (``--method grid``) some minutes. The
log's odometry is taken as the true path (it has to be corrected, as that of the Intel lab is), and
noisy odometry is made of it.
"""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

import numpy as np
from mappings import aligned
from scipy.spatial import cKDTree

from app.lab.localize.reading.carmen import measurements
from app.lab.mapping.looks import REACH_M
from robot.geometry import Pose2
from robot.mapping.graph.graph_slam import GraphSettings, GraphSlam
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cell_mapper import CellMapper
from robot.mapping.grid.fast_slam import WALLS, FastSlam

NEAR_M = 0.1
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


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("log", type=Path, help="a CARMEN log with corrected odometry")
    parser.add_argument("--seeds", type=int, nargs=2, default=(100, 103), metavar=("A", "END"))
    parser.add_argument("--method", choices=("graph", "grid"), default="graph")
    given = parser.parse_args()
    poses, scans = zip(*measurements(given.log), strict=True)
    true = np.array([pose.to_array() for pose in poses])
    walls = cKDTree(
        np.vstack(
            [p.apply(s.within(0, REACH_M).points()) for p, s in zip(poses, scans, strict=True)]
        )
    )
    for seed in range(*given.seeds):
        rng = np.random.default_rng(seed)
        scale = 1 + SCALE_SD * rng.normal(), 1 + SCALE_SD * rng.normal()
        slam, odometry = mapper(given.method, poses[0], rng), [poses[0]]
        begun = time.process_time()
        for k, scan in enumerate(scans):
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


def rms(path: np.ndarray, true: np.ndarray) -> float:
    """Of the distances after alignment [m]."""
    off = aligned(path[:, :2], true[:, :2]).apply(path[:, :2]) - true[:, :2]
    return float(np.sqrt((off**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()
