"""Benchmark of one update of the particle filter, beside the C++ core of nav2_amcl.

Both use the same field, drive, 60 rays and number of particles, and resample at every scan. They
take turns of several updates. The first update of a turn does not count, as caches are cold. An
update consists of noise, motion, weighing, resampling, and the estimate: clusters with their means
and covariances. Ours is timed as a program calls it, in Python; for nav2 only its core is timed.
All times are those of the one working thread, so that other programs do not count.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from app.settings.config import MAPS
from benchmarks.nav2_amcl import LIBRARY, VERSION, Nav2Amcl
from benchmarks.result import Result
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Pose2, Twist2
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import sensor_model
from robot.localization.parameters import LocalizationParameters
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import Scan

TURNS = {500: 25, 5000: 10, 20_000: 4}
"""Number of turns of each filter, by number of particles."""
IN_TURN = 10
"""Updates in a turn."""
MAIN = 20_000
"""Number of particles of the main result; the others are additional figures."""
PEERS = {
    f"nav2_amcl {VERSION}, beam model (what the package's AMCL runs)": True,
    f"nav2_amcl {VERSION}, likelihood field (nav2's default)": False,
}
SD_XY, SD_THETA = 0.02, 0.05
"""Standard deviations of the start pose [m], [rad]."""
PARAMETERS = LocalizationParameters()


@dataclass(frozen=True)
class FilterStep:
    """Odometry before and after a step, and the scan after it."""

    before: Pose2
    after: Pose2
    scan: Scan


def measure() -> Result:
    """Measure median times, and the memory of the filter."""
    field = load_field("stub", MAPS)
    times = {count: _compare(field, count) for count in TURNS}
    more = {}
    for count, medians in times.items():
        more[f"N = {count}: brickpose [us]"] = 1e6 * medians["brickpose"]
        for name in PEERS.keys() & medians.keys():
            more[f"N = {count}: {name} [us]"] = 1e6 * medians[name]
            more[f"N = {count}: {name}, times as long"] = medians[name] / medians["brickpose"]
    more |= _memory()
    if not LIBRARY.exists():
        sys.stderr.write("nav2_amcl is not built, so there is no peer; `make bench` builds it\n")
    main = {name: 1e3 * seconds for name, seconds in times[MAIN].items()}
    ours = main.pop("brickpose")
    return Result(f"ms an update of {MAIN} particles by 60 rays", ours, main, more)


def _compare(field: Field, count: int) -> dict[str, float]:
    """Return the median time [s] of an update, by program."""
    ours = ours_on(field, count)
    motion, sensor = PARAMETERS.motion, PARAMETERS.sensor
    peers = {
        name: Nav2Amcl(count, field.occupancy(0.005), motion, sensor, beam_model=beam_model)
        for name, beam_model in PEERS.items()
        if LIBRARY.exists()
    }
    for peer in peers.values():
        peer.start(Pose2(), SD_XY, SD_THETA)
    work: dict[str, Callable[[FilterStep], float]] = {"brickpose": lambda step: update(ours, step)}
    for name, peer in peers.items():
        work[name] = partial(_update_peer, peer)
    taken: dict[str, list[float]] = {name: [] for name in work}
    steps = list(drive(field, TURNS[count] * IN_TURN))
    for turn in range(0, len(steps), IN_TURN):
        for name, one_update in work.items():
            times = [one_update(step) for step in steps[turn : turn + IN_TURN]]
            taken[name] += times[1:]
    return {name: float(np.median(times)) for name, times in taken.items()}


def _update_peer(peer: Nav2Amcl, step: FilterStep) -> float:
    return peer.update(step.before, step.after, step.scan)


def ours_on(field: Field, count: int) -> ParticleFilter:
    """Return our filter with the defaults and a fixed number of particles."""
    sensor = PARAMETERS.sensor
    entries = EntryField.build(
        field, resolution=sensor.field_resolution, max_distance=sensor.laser_likelihood_max_dist
    )
    made = ParticleFilter(
        PARAMETERS.motion.model(),
        sensor_model(sensor, entries, field.edges),
        field,
        replace(PARAMETERS.filter, min_particles=count, max_particles=count),
        np.random.default_rng(0),
        likelihood_weight=sensor.likelihood_weight,
    )
    made.set_pose(Pose2(), np.diag(np.square([SD_XY, SD_XY, SD_THETA])))
    return made


def update(belief: ParticleFilter, step: FilterStep) -> float:
    """Update the filter and return the computing time, with the estimate [s]."""
    moved = step.before.inverse() @ step.after
    start = time.thread_time()
    belief.predict(moved)
    belief.correct(step.scan)
    hypotheses = belief.hypotheses
    taken = time.thread_time() - start
    assert hypotheses
    return taken


def drive(field: Field, count: int, rays: int = 60) -> Iterator[FilterStep]:
    """Drive along a circle at 15 scans/s; odometry errs by 1 % and 2 %, ranges by 0.3 mm."""
    rng = np.random.default_rng(7)
    bearings = np.radians(np.linspace(-31, 31, rays))
    truth = odometry = Pose2()
    twist, odometry_twist = Twist2(0.15, 0.79), Twist2(0.1515, 0.8058)
    for tick in range(count):
        truth, before = truth @ twist.integrate(1 / 15), odometry
        odometry = odometry @ odometry_twist.integrate(1 / 15)
        ranges = np.empty((1, rays))
        cast_rays(truth.to_array()[None], bearings, field.edge_index, 1.0, ranges)
        noisy = ranges[0] + rng.normal(0, 0.0003, rays)
        yield FilterStep(before, odometry, Scan(tick / 15, bearings, noisy))


def _memory() -> dict[str, float]:
    """Measure the filter's memory in another process, as arrays of compiled code are not traced."""
    command = [sys.executable, "-m", "benchmarks.filter_memory"]
    figures = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    names = ("in arrays of its own", "most during an update (resident)", "table of the field")
    return {
        f"N = {MAIN}: memory {name} [MB]": float(value)
        for name, value in zip(names, figures, strict=True)
    }
