"""The C++ core of nav2_amcl as a peer: ``python -m benchmarks.nav2_amcl SDIST`` builds it.

The sources are those of the package ``amcl`` from PyPI, which took them from nav2. They are built
here with -O3 -march=native and called through five C functions of our own: the package's own class
only offers the beam model, but nav2's default is the likelihood field. Its licence is the GPL: it
is only used to measure, and the product neither imports nor ships it.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array, Pose2
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.scan import Scan

VERSION = "0.1.2"
"""Version of the package; its sources are those of nav2 in 2025."""
LIBRARY = Path(sys.prefix) / "peers" / f"nav2_amcl-{VERSION}.so"
FLAGS = ("-O3", "-march=native", "-DNDEBUG", "-DHAVE_DRAND48", "-fPIC", "-w")
"""NDEBUG as in the package's release build: its assertions fail with a small sigma_hit."""
C_SOURCES = (
    "map/map.c", "map/map_range.c", "pf/eig3.c", "pf/pf.c", "pf/pf_kdtree.c", "pf/pf_pdf.c",
    "pf/pf_vector.c",
)  # fmt: skip
CPP_SOURCES = (
    "map/map_cspace.cpp", "motion_model/differential_motion_model.cpp",
    "sensors/laser/beam_model.cpp", "sensors/laser/laser.cpp",
    "sensors/laser/likelihood_field_model.cpp",
)  # fmt: skip


def build(sdist: Path, library: Path = LIBRARY) -> None:
    """Compile the core of a source package to a library."""
    library.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(sdist) as archive:
            archive.extractall(folder, filter="data")
        root = next(Path(folder).iterdir())
        include = f"-I{root / 'include'}"
        objects = [f"{folder}/{Path(name).stem}.o" for name in C_SOURCES]
        for name, made in zip(C_SOURCES, objects, strict=True):
            _run("gcc", *FLAGS, include, "-c", str(root / "src" / name), "-o", made)
        sources = [str(root / "src" / name) for name in CPP_SOURCES]
        ours = str(Path(__file__).with_suffix(".cpp"))
        target = ("-shared", "-o", str(library))
        _run("g++", "-std=c++17", *FLAGS, include, ours, *sources, *objects, *target)


def _run(*command: str) -> None:
    subprocess.run(command, check=True)


class Nav2Amcl:
    """nav2's filter with a fixed number of particles, resampled at every scan."""

    def __init__(
        self,
        particles: int,
        grid: OccupancyGrid,
        motion: MotionParameters,
        sensor: SensorParameters,
        *,
        beam_model: bool,
    ) -> None:
        self._library = _load()
        self._range_max = sensor.laser_max_range
        height, width = grid.data.shape
        alphas = np.array([motion.alpha1, motion.alpha2, motion.alpha3, motion.alpha4])
        laser = np.array([
            sensor.z_hit, sensor.z_short, sensor.z_max, sensor.z_rand, sensor.sigma_hit,
            sensor.lambda_short, sensor.laser_likelihood_max_dist,
        ])  # fmt: skip
        self._filter = ctypes.c_void_p(
            self._library.create(
                particles,
                np.ascontiguousarray(grid.data, dtype=np.int8).ctypes.data_as(ctypes.c_char_p),
                width,
                height,
                ctypes.c_double(grid.resolution),
                _pointer(grid.origin.to_array()),
                _pointer(alphas),
                _pointer(laser),
                sensor.max_beams,
                int(beam_model),
            )
        )

    def start(self, pose: Pose2, sd_xy: float, sd_theta: float) -> None:
        """Start around a pose, with standard deviations [m] and [rad]."""
        deviations = np.array([sd_xy, sd_xy, sd_theta])
        self._library.start(self._filter, _pointer(pose.to_array()), _pointer(deviations))

    def update(self, before: Pose2, after: Pose2, scan: Scan) -> float:
        """Update with a step of odometry and a scan; return the core's computing time [s]."""
        delta = np.array([after.x - before.x, after.y - before.y, before.turn_to(after)])
        returned = np.where(scan.hit, scan.ranges, self._range_max)
        ranges = np.ascontiguousarray(np.column_stack([returned, scan.bearings]))
        odometry = after.to_array()
        arguments = (self._filter, _pointer(odometry), _pointer(delta), _pointer(ranges),
                     len(ranges), ctypes.c_double(self._range_max))  # fmt: skip
        start = time.thread_time()
        self._library.update(*arguments)
        return time.thread_time() - start

    @property
    def mean(self) -> Pose2:
        """Mean pose of all particles."""
        mean = np.zeros(3)
        self._library.estimate(self._filter, _pointer(mean))
        return Pose2.from_array(mean)

    def __del__(self) -> None:
        self._library.destroy(self._filter)


def _load() -> Any:
    library = ctypes.CDLL(str(LIBRARY))
    library.create.restype = ctypes.c_void_p
    return library


def _pointer(values: Array | NDArray[np.float64]) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


if __name__ == "__main__":
    build(Path(sys.argv[1]))
