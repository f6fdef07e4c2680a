"""Benchmark of global localization on the Wean Hall log, with several seeds.

The recording (CMU, 16-831) is not part of this repository. It is converted to a map of map_server
and a bag, and ``brickpose localize`` runs on them as a user would run it.
"""

from __future__ import annotations

import gzip
import io
import json
import math
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from app.settings.config import ROOT
from benchmarks.lasers.laser_bags import LaserBag
from benchmarks.result import Result
from robot.fields.grid_map import save_map_yaml
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2, wrap_angle
from robot.settings import SettingError

DATA = ROOT.parent / "shared" / "data" / "amcl_wean"
REFERENCE_STAMP, REFERENCE = 131.882, Pose2(39.84, 41.07, 1.39)
"""Measured by another program's filter; after it the robot drives on for 0.36 m and stops."""
NEAR_M, NEAR_RAD = 0.2, 0.1
TRACK = DATA / "reference_run1.csv"
"""The whole path by the same other filter: seconds and centimetres."""
SETTLED, WRONG_M = 23.0, 1.5
"""The reference knows its place from this stamp on [s]; a pose farther than this from it is wrong
[m]."""
BREAK = 1.0
"""Wrong poses farther apart than this are not in one stretch [s]."""
SEEDS = range(10)
BEGAN = 1_000_000_000.0
"""Added to the log's stamps [s]: they begin at 0, which in ROS means that there is no stamp."""
FREE, OCCUPIED = 0.8, 0.35
"""A cell of the file is free from the first probability on, and occupied up to the second."""
FARTHEST = 81.8
"""Longest range [m]: a ray without a return has 8183 cm in the log."""


def write_map(path: Path, data: Path = DATA) -> None:
    """Write the map of the log: in its file 1 is free, -1 unknown, and rows go along x."""
    with gzip.open(data / "wean.dat.gz", "rt") as file:
        lines = iter(file)
        while not next(lines).startswith("global_map"):
            pass
        free = np.array([line.split() for line in lines if line.strip()], dtype=np.float64).T
    cells = np.full(free.shape, -1, dtype=np.int8)
    cells[free >= FREE] = 0
    cells[(free >= 0) & (free <= OCCUPIED)] = 100
    save_map_yaml(OccupancyGrid(cells, 0.1, Pose2()), path)


def write_bag(path: Path, kind: str = "mcap", data: Path = DATA, begin: float = 0.0) -> None:
    """Write the log from a time on [s] as a bag: 180 beams from the right, laser 0.25 m ahead."""
    with gzip.open(data / "robotdata1.log.gz", "rt") as file, LaserBag(path, kind) as bag:
        place = Pose2(0.25, 0.0, 0.0)
        bag.transform(BEGAN, "base_link", "laser", place, topic="/tf_static")
        for line in file:
            tag, *words = line.split()
            numbers = np.array(words, dtype=np.float64)
            if numbers[-1] < begin:
                continue
            stamp = BEGAN + float(numbers[-1])
            bag.odometry(stamp, Pose2(numbers[0] / 100, numbers[1] / 100, numbers[2]))
            if tag == "L":
                first, step = math.radians(-89.5), math.radians(1)
                ranges = numbers[6:186] / 100
                bag.scan(stamp, ranges, first=first, step=step, reach=(0.0, FARTHEST))


def localized(folder: Path, seed: int) -> tuple[dict[str, object], Array, Array]:
    """Run the command on the map and bag in a folder; return results, stamps and poses."""
    out = folder / f"seed_{seed}"
    arguments = ["localize", str(folder / "bag"), "--map", str(folder / "wean.yaml")]
    with redirect_stdout(io.StringIO()):
        code = main([*arguments, "--out", str(out), "--seed", str(seed)])
    if code:
        raise RuntimeError(f"seed {seed} ended with {code}")
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    if not (out / "localized.tum").exists():
        return results, np.empty(0), np.empty((0, 3))
    way = parse_tum((out / "localized.tum").read_text(encoding="utf-8"), "localized.tum")
    return results, way.stamps - BEGAN, way.poses


def wrong_poses(stamps: Array, poses: Array) -> tuple[int, int, float]:
    """Return how many poses can be judged, how many are wrong, and the longest wrong time [s]."""
    track = np.genfromtxt(TRACK, delimiter=",", comments="#")
    judged = stamps >= SETTLED
    stamps, poses = stamps[judged], poses[judged]
    true = [np.interp(stamps, track[:, 0], track[:, column] / 100) for column in (1, 2)]
    wrong_stamps = stamps[np.hypot(poses[:, 0] - true[0], poses[:, 1] - true[1]) > WRONG_M]
    parts = np.split(wrong_stamps, np.flatnonzero(np.diff(wrong_stamps) > BREAK) + 1)
    longest = max((float(part[-1] - part[0]) for part in parts if len(part)), default=0.0)
    return len(stamps), len(wrong_stamps), longest


def error_at_reference(stamps: Array, poses: Array) -> tuple[float, float]:
    """Return distance [m] and angle [rad] from the reference, at its stamp."""
    pose = poses[int(np.argmin(np.abs(stamps - REFERENCE_STAMP)))]
    turn = abs(wrap_angle(float(pose[2]) - REFERENCE.theta))
    return math.hypot(pose[0] - REFERENCE.x, pose[1] - REFERENCE.y), turn


def require_data() -> None:
    """Refuse to run without the recording."""
    if not DATA.is_dir():
        raise SettingError(f"the Wean Hall log is not there: {DATA}")


def measure(seeds: range = SEEDS) -> Result:
    """Measure how many of ten seeds are near the reference at its stamp."""
    require_data()
    near, far, turns, known, rates = 0, [], [], [], []
    judged, wrong, longest, withdrawn = 0, 0, 0.0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_map(folder / "wean.yaml")
        write_bag(folder / "bag")
        for seed in seeds:
            results, stamps, poses = localized(folder, seed)
            withdrawn += results["scans"]["withdrawn"]  # type: ignore[index]
            rates.append(results["rates"]["updates_per_s"])  # type: ignore[index]
            if not len(stamps):
                sys.stderr.write(f"seed {seed}: nothing told\n")
                continue
            count, wrong_count, lasted = wrong_poses(stamps, poses)
            judged, wrong, longest = judged + count, wrong + wrong_count, max(longest, lasted)
            distance, turn = error_at_reference(stamps, poses)
            near += distance <= NEAR_M and turn <= NEAR_RAD
            far.append(distance)
            turns.append(turn)
            known.append(float(stamps[0]))
            sys.stderr.write(f"seed {seed}: {distance:.3f} m, {turn:.3f} rad\n")
    more = {
        "seeds": float(len(seeds)),
        "distance, median [m]": float(np.median(far)),
        "distance, largest [m]": max(far),
        "heading, largest [rad]": max(turns),
        "known after, median [s]": float(np.median(known)),
        "known after, longest [s]": max(known),
        "never told": float(len(seeds) - len(known)),
        "told": float(judged),
        "told and wrong [%]": 100 * wrong / max(judged, 1),
        "told and wrong, longest [s]": longest,
        "withdrawn": float(withdrawn),
        "updates a second, median": float(np.median(rates)),
    }
    unit = f"of {len(seeds)} starts over the whole floor within {NEAR_M} m and {NEAR_RAD} rad"
    return Result(unit, float(near), {}, more)
