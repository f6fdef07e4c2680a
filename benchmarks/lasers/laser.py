"""Benchmark of a laser update on a large map: 10,000 particles, 360 or 1080 beams, 4 M cells.

A robot is simulated in a building of 100 m x 100 m with cells of 5 cm. Ours is the filter of
``brickpose localize`` with its defaults and a fixed number of particles. The peer is the C++ core
of nav2_amcl with nav2's defaults. Both take turns on the same scans. All times are those of the one
working thread.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.settings import LASER, LaserSettings
from benchmarks.lasers.laser_robot import Laser, measurements, wander
from benchmarks.nav2_amcl import LIBRARY, VERSION, Nav2Amcl
from benchmarks.result import Result
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorModel, SensorParameters
from robot.localization.particles.particle_filter import ParticleFilter

SIDE, CELL = 2048, 0.05
"""Cells on each side of the map, and the side of a cell [m]."""
PARTICLES = 10_000
BEAMS = (360, 1080)
SCANS, WARM = 60, 5
START = Pose2(51.0, 51.0, 0.4)
SD_XY, SD_THETA = 0.3, 0.1
NAV2 = f"nav2_amcl {VERSION}, likelihood field"
NAV2_MOTION = MotionParameters(alpha1=0.2, alpha2=0.2, alpha3=0.2, alpha4=0.2)
NAV2_SENSOR = SensorParameters(
    sigma_hit=0.2, z_hit=0.5, z_rand=0.5, laser_max_range=100.0, laser_likelihood_max_dist=2.0
)


def building() -> OccupancyGrid:
    """Return a map of 5 m rooms with doors and objects, on 2048 x 2048 cells."""
    rng = np.random.default_rng(0)
    cells = np.zeros((SIDE, SIDE), dtype=np.int8)
    room = 100
    for line in range(0, SIDE, room):
        cells[line : line + 2] = cells[:, line : line + 2] = 100
    for row in range(0, SIDE - room, room):
        for column in range(0, SIDE - room, room):
            door = int(rng.integers(15, room - 40))
            cells[row + door : row + door + 24, column : column + 2] = 0
            cells[row : row + 2, column + door : column + door + 24] = 0
            things = rng.integers(10, room - 20, (3, 2))
            for down, right in things:
                cells[row + down : row + down + 8, column + right : column + right + 6] = 100
    cells[:2] = cells[-2:] = cells[:, :2] = cells[:, -2:] = 100
    middle = slice(SIDE // 2 - 30, SIDE // 2 + 30)
    cells[middle, middle] = 0
    return OccupancyGrid(cells, CELL, Pose2())


def measure() -> Result:
    """Measure median times, and the time to prepare the map."""
    begun = time.thread_time()
    laser_map = LaserMap.of(building(), "building")
    read = time.thread_time()
    sensor = laser_map.sensor(LASER.sensor, LaserSettings())
    more = {
        "map of 4 M cells: field [s]": read - begun,
        "map of 4 M cells: tables [s]": time.thread_time() - read,
    }
    peer: dict[str, float] = {}
    ours = 0.0
    for beams in BEAMS:
        laser = Laser(beams=beams)
        times = _times(laser_map, sensor, laser)
        ours = times["brickpose"]
        more[f"{beams} beams: brickpose [ms]"] = ours
        more[f"{beams} beams: updates/s"] = 1e3 / ours
        more[f"{beams} beams: off the truth at the end [m]"] = times["off [m]"]
        if NAV2 in times:
            more[f"{beams} beams: {NAV2} [ms]"] = peer[NAV2] = times[NAV2]
            more[f"{beams} beams: {NAV2}, off the truth at the end [m]"] = times["peer off [m]"]
    if not LIBRARY.exists():
        sys.stderr.write("nav2_amcl is not built, so there is no peer; `make bench` builds it\n")
    return Result(f"ms an update of {PARTICLES} particles, {BEAMS[-1]} beams", ours, peer, more)


def _times(laser_map: LaserMap, sensor: SensorModel, laser: Laser) -> dict[str, float]:
    """Return the median times [ms] of an update by program, and their errors at the end [m]."""
    p = LASER.filter
    fixed = replace(p, min_particles=PARTICLES, max_particles=PARTICLES)
    ours = ParticleFilter(
        LASER.motion.model(), sensor, laser_map.field, fixed, np.random.default_rng(0),
        likelihood_weight=LASER.sensor.likelihood_weight,
    )  # fmt: skip
    ours.set_pose(START, np.diag(np.square([SD_XY, SD_XY, SD_THETA])))
    peer = None
    if LIBRARY.exists():
        peer = Nav2Amcl(PARTICLES, laser_map.grid, NAV2_MOTION, NAV2_SENSOR, beam_model=False)
        peer.start(START, SD_XY, SD_THETA)
    seen = list(wander(laser_map, laser, SCANS / 10 * 4, 0, START))[::4]
    taken: dict[str, list[float]] = {"brickpose": [], NAV2: []}
    before = seen[0].odometry
    for measurement in measurements(iter(seen), laser):
        after = measurement.odom_from_robot
        begun = time.thread_time()
        ours.predict(before.inverse() @ after)
        ours.correct(measurement.scan)
        assert ours.hypotheses
        taken["brickpose"].append(time.thread_time() - begun)
        if peer is not None:
            taken[NAV2].append(peer.update(before, after, measurement.scan))
        before = after
    figures = {name: 1e3 * float(np.median(t[WARM:])) for name, t in taken.items() if t}
    figures["off [m]"] = ours.hypotheses[0].pose.distance_to(seen[-1].truth)
    if peer is not None:
        figures["peer off [m]"] = peer.mean.distance_to(seen[-1].truth)
    return figures
