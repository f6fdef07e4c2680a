"""Measures how exact maps in cells are: ``grid_trials.py square stub``.

Not a test: each drive takes some seconds. The drives are those of ``mapping_trials.py``: one lap of
the figure-eight.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from calibrations import SPEC, driven
from mappings import STEP, aligned, eight
from scipy.spatial import cKDTree

from app.settings.config import MAPS
from robot.driving.figure_eight import FigureEight
from robot.fields.edges import sample
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.mapping.grid.beams import of_pictures, steps_of
from robot.mapping.grid.fast_slam import TAPE, FastSlam
from robot.mapping.moving import moving


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("maps", nargs="+", metavar="MAP")
    parser.add_argument("--seeds", type=int, nargs=2, default=(61000, 61012), metavar=("A", "END"))
    given = parser.parse_args()
    for name in given.maps:
        rows = np.array([errors(name, seed) for seed in range(*given.seeds)])
        for label, value in (("median", np.median), ("worst", np.max)):
            path, mean, odometry = value(rows, axis=0)
            print(
                f"{name}: {label} path {path:.1f}, edges {mean:.1f}, odometry {odometry:.1f} mm",
                flush=True,
            )


def errors(name: str, seed: int) -> tuple[float, float, float]:
    """Of the path, of the edges' mean, and of the path by odometry [mm]; the map on the path."""
    seconds = math.ceil(FigureEight().lap)
    log, _, poses = driven("default", seed, seconds, eight, name, calibrated=True)
    some = moving(log, SPEC)
    log, true = log.some(some), poses[some][:, :2]
    slam, by_wheels = FastSlam(TAPE, Pose2(), np.random.default_rng(seed)), [Pose2()]
    steps = steps_of(log, SPEC)
    for step, beams in zip([Pose2(), *steps], of_pictures(log, SPEC), strict=True):
        slam.update(step, beams)
    for step in steps:
        by_wheels.append(by_wheels[-1] @ step)
    odometry = np.array([pose.to_array()[:2] for pose in by_wheels])
    truth, _ = sample(load_field(name, MAPS).edges, STEP / 4)
    path = slam.path[:, :2]
    off, _ = cKDTree(truth).query(aligned(path, true).apply(slam.ends))
    return rms(path, true), 1e3 * float(off.mean()), rms(odometry, true)


def rms(path: np.ndarray, true: np.ndarray) -> float:
    """Of the distances after alignment [mm]."""
    off = aligned(path, true).apply(path) - true
    return 1e3 * float(np.sqrt((off**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()
