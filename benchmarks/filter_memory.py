"""Measure the memory of the particle filter, in a process of its own (Linux).

Prints three figures in MB: the arrays that the filter keeps, the peak growth of the process while
the filter is made and updated, and the field's tables, which the sensor model keeps for any filter.
"""

from __future__ import annotations

import ctypes
import gc
from pathlib import Path

from app.settings.config import MAPS
from benchmarks.filter import MAIN, drive, ours_on, update
from robot.fields.field_loading import load_field
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.particles.particle_filter import ParticleFilter

MB = 1e6


def _status(name: str) -> int:
    """Return a value of this process's status [bytes]."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(name))


def _kept(belief: ParticleFilter) -> int:
    weighed, kept, clusters = belief.cloud, belief._particles, belief._clusters
    floats = (weighed.poses, weighed.weights, kept.poses, kept.weights)
    return sum(a.nbytes for a in floats) + clusters.labels.nbytes + clusters.cells.nbytes


def main() -> None:
    """Run a small filter first, to compile and allocate, then measure a large one."""
    field = load_field("stub", MAPS)
    steps = list(drive(field, 30))
    belief = ours_on(field, 50)
    for step in steps:
        update(belief, step)
    gc.collect()
    # Return freed memory to the system, as its reuse would not be measured, and reset the peak.
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = _status("VmRSS")
    filter_parameters = belief.parameters.__class__(min_particles=MAIN, max_particles=MAIN)
    large = ParticleFilter(belief.motion, belief.sensor, field, filter_parameters, belief._rng)
    for step in steps:
        update(large, step)
    grown = _status("VmHWM") - before
    assert isinstance(belief.sensor, LikelihoodField)
    tables = belief.sensor.field
    print(_kept(large) / MB, grown / MB, (tables.planes.nbytes + tables.distances.nbytes) / MB)


if __name__ == "__main__":
    main()
