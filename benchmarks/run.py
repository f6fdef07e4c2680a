"""``brickpose bench``: runs benchmarks by name."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from benchmarks import (
    accuracy,
    crowd,
    driving,
    ends,
    growth,
    hostile_files,
    instructions,
    live,
    long_maps,
    loop,
    mapping,
    navigation,
    physics,
    recovery,
    render,
    scan,
    soak,
    start,
    sweep,
    worth,
)
from benchmarks import filter as particle_filter
from benchmarks.hat import delay, driver, journeys, official_library, serial_line, wheels
from benchmarks.lasers import laser, wean
from benchmarks.pictures import lane
from benchmarks.result import Result
from benchmarks.topics import recording, ros2, routes
from robot.settings import SettingError

BENCHMARKS: dict[str, Callable[[], Result]] = {
    "accuracy": accuracy.measure,
    "crowd": crowd.measure,
    "driver": driver.measure,
    "driving": driving.measure,
    "encoders": delay.measure,
    "ends": ends.measure,
    "filter": particle_filter.measure,
    "growth": growth.measure,
    "hostile_files": hostile_files.measure,
    "instructions": instructions.measure,
    "journeys": journeys.measure,
    "lane": lane.measure,
    "laser": laser.measure,
    "loop": loop.measure,
    "live": live.measure,
    "long_maps": long_maps.measure,
    "mapping": mapping.measure,
    "navigation": navigation.measure,
    "official_library": official_library.measure,
    "physics": physics.measure,
    "recording": recording.measure,
    "recovery": recovery.measure,
    "render": render.measure,
    "ros2": ros2.measure,
    "routes": routes.measure,
    "scan": scan.measure,
    "serial_line": serial_line.measure,
    "soak": soak.measure,
    "start": start.measure,
    "sweep": sweep.measure,
    "wean": wean.measure,
    "wheels": wheels.measure,
    "worth": worth.measure,
}

LONG = (
    "crowd",
    "driving",
    "ends",
    "growth",
    "hostile_files",
    "instructions",
    "journeys",
    "lane",
    "long_maps",
    "mapping",
    "official_library",
    "ros2",
    "routes",
    "serial_line",
    "soak",
    "wean",
)
"""Benchmarks that take minutes each, most in processes of their own; they run only if named."""


MOST_MINUTES = 10_000
"""A week: longer is a mistake."""


def run(names: Sequence[str], file: Path | None, minutes: float | None = None) -> int:
    """Run benchmarks, print the figures and write them to a file.

    Args:
        names: which; by default all that are not long.
        file: where the figures are written as JSON, too.
        minutes: how long the soak test runs.

    Raises:
        SettingError: a name is unknown, or the time is not above zero or has no effect.
    """
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        raise SettingError(f"no benchmark {unknown[0]!r}; valid are {', '.join(BENCHMARKS)}")
    benchmarks = dict(BENCHMARKS)
    if minutes is not None:
        if "soak" not in names:
            raise SettingError("--minutes has no effect without soak; valid is: bench soak")
        if not 0 < minutes <= MOST_MINUTES:
            raise SettingError(f"--minutes is {minutes:g}; valid is above 0 up to {MOST_MINUTES}")
        benchmarks["soak"] = partial(soak.measure, minutes)
    results = {}
    for name in names or [name for name in BENCHMARKS if name not in LONG]:
        results[name] = benchmarks[name]()
        sys.stdout.write("\n".join(results[name].lines(name)) + "\n")
        sys.stdout.flush()
    if file is not None:
        content = {name: result.to_json() for name, result in results.items()}
        file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    return 0
