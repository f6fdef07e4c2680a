"""Benchmark on a real robot's pictures of a lane: white and dashed yellow tape on a dark floor.

The sequence (a Duckiebot's, 23 pictures) is not part of this repository. ``brickpose localize``
runs on its folder as a user would run it. Field and camera (``lane.svg``, ``lane_camera.yaml``)
were fitted on the same pictures, and odometry is the motion by the overhead cameras with noise. So
the figures say how well the program follows, not how well an unknown camera or field is measured.
"""

from __future__ import annotations

import io
import math
import sys
import tempfile
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.command_line import main
from app.features.lab.trajectories.reading import parse_tum
from app.settings.config import ROOT
from app.trajectories.tum_file import write_tum
from benchmarks.pictures.overhead import Aligned, Overhead, align
from benchmarks.result import Result
from robot.settings import SettingError

DATA = ROOT.parent / "shared" / "data" / "duckie_lane_seq"
HERE = Path(__file__).parent
FIELD, CAMERA, SETTINGS = HERE / "lane.svg", HERE / "lane_camera.yaml", HERE / "lane.toml"
SEEDS = range(6)
LOST_M, LOST_RAD = 0.1, math.radians(15)
"""A picture is lost whose pose is farther off than this."""


@dataclass(frozen=True)
class LaneRun:
    """One run of the command on the sequence."""

    aligned: Aligned
    stale: tuple[str, ...]
    """Names of the pictures that were told as stale."""
    pictures: int
    """Number of pictures with a pose."""

    @property
    def lost(self) -> int:
        """Number of pictures whose pose is far off."""
        wrong = (self.aligned.distances > LOST_M) | (self.aligned.turns > LOST_RAD)
        return int(wrong.sum())


def run_lane(folder: Path, seed: int, data: Path = DATA) -> LaneRun:
    """Run the command with the odometry of a seed; its files go to a folder."""
    overhead = Overhead.load(_trajectory_file(data))
    write_tum(folder / "odometry.tum", overhead.odometry(seed))
    out = folder / "lane.tum"
    arguments = [
        "localize", data / "images", "--map", FIELD, "--camera", CAMERA, "--config", SETTINGS,
        "--odometry", folder / "odometry.tum", "--seed", seed, "--out", out,
    ]  # fmt: skip
    with redirect_stdout(io.StringIO()) as output:
        code = main([str(argument) for argument in arguments])
    if code:
        raise RuntimeError(f"seed {seed} ended with {code}")
    stale = [line.split()[0] for line in output.getvalue().splitlines() if " is stale" in line]
    trajectory = parse_tum(out.read_text(encoding="utf-8"), out.name)
    return LaneRun(align(trajectory, overhead), tuple(stale), len(trajectory.stamps))


def _trajectory_file(data: Path) -> Path:
    for path in sorted(data.glob("*.yaml")):
        with path.open(encoding="utf-8") as file:
            if file.readline().startswith("begin_time_stamp"):
                return path
    raise SettingError(f"{data} has no file with the poses of overhead cameras")


def require_data() -> None:
    """Refuse to run without the sequence."""
    if not DATA.is_dir():
        raise SettingError(f"the lane's sequence is not there: {DATA}")


def measure(seeds: range = SEEDS) -> Result:
    """Measure position and heading beside the overhead poses, over seeds of the odometry."""
    require_data()
    runs = []
    with tempfile.TemporaryDirectory() as name:
        for seed in seeds:
            runs.append(run_lane(Path(name), seed))
            sys.stderr.write(f"seed {seed}: {_words(runs[-1])}\n")
    figures = np.array([_figures(run.aligned) for run in runs])
    names = ("position, median [mm]", "position, 90 % [mm]", "heading, median [deg]",
             "heading, 90 % [deg]")  # fmt: skip
    more = {
        "seeds": float(len(runs)),
        "pictures with a pose": float(runs[0].pictures),
        "told as stale": float(np.mean([len(run.stale) for run in runs])),
        "lost, worst seed": float(max(run.lost for run in runs)),
        **dict(zip(names, figures.mean(axis=0).tolist(), strict=True)),
        **{f"{n}, worst seed": v for n, v in zip(names, figures.max(axis=0).tolist(), strict=True)},
        "fitted turn [deg]": math.degrees(np.mean([run.aligned.moved.theta for run in runs])),
        "fitted shift in x [mm]": 1e3 * float(np.mean([run.aligned.moved.x for run in runs])),
        "fitted shift in y [mm]": 1e3 * float(np.mean([run.aligned.moved.y for run in runs])),
        "fitted time shift [s]": float(np.mean([run.aligned.shift for run in runs])),
    }
    unit = f"mm from the overhead poses, median of {runs[0].pictures} pictures"
    return Result(unit, float(figures[:, 0].mean()), {}, more)


def _figures(aligned: Aligned) -> list[float]:
    millimetres, degrees = 1e3 * aligned.distances, np.degrees(aligned.turns)
    return [
        float(np.median(millimetres)),
        float(np.percentile(millimetres, 90)),
        float(np.median(degrees)),
        float(np.percentile(degrees, 90)),
    ]


def _words(run: LaneRun) -> str:
    a, b, c, d = _figures(run.aligned)
    return f"{a:.1f} and {b:.1f} mm, {c:.2f} and {d:.2f} degrees; stale: {', '.join(run.stale)}"
