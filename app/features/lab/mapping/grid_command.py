"""``brickpose map`` with an occupancy grid: of tape, or of the walls that a laser saw."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import deque
from collections.abc import Iterator
from itertools import chain, count
from pathlib import Path

import numpy as np

from app.console import say
from app.features.lab.mapping.looks import Observation, pictures, scans
from app.result_files import require_new, require_writable
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.estimation.fit_quality import FitQuality
from robot.fields.grid_map import save_map_yaml
from robot.geometry import Pose2
from robot.mapping.graph.graph_slam import TORN_AFTER, GraphSettings, GraphSlam
from robot.mapping.grid.cell_mapper import CellMapper
from robot.mapping.grid.fast_slam import FEWEST_MET, TAPE, WALLS, FastSlam
from robot.mapping.tape_map import MappingError
from robot.settings import SettingError

PAUSE_S = 30.0
"""A robot that takes no scan on its way for so long may have been carried [s]."""
JUMP = 2.0
"""A step of odometry that is so many times the longest one around may be none."""
WITHIN_95 = 2.45
"""Deviations of a place in the plane that 95 % lie within."""


def map_in_cells(parsed: argparse.Namespace, method: str, *, laser: bool) -> int:
    """Draw a ROS map, and the robot's path; return 0.

    Args:
        parsed: the command line.
        method: graph, or grid for particles.
        laser: whether a laser saw walls, and not a camera tape.

    Raises:
        MappingError, BagError, SettingError, RecordingError, OSError: says what cannot be used.
    """
    out: Path = parsed.out
    if out.suffix.lower() != ".yaml":
        raise SettingError(f"--out is {out}; valid is a file that ends in .yaml, for a ROS map")
    require_writable(*_written(out))
    if not parsed.force:
        require_new(*_written(out))
    looks = iter((scans if laser else pictures)(parsed))
    names = _names(out, parsed.force)
    name, drawn = next(names), 0
    while (first := next(looks, None)) is not None:
        mapper = _mapper(parsed, method, laser)
        stamps, looks = _draw(mapper, first, looks)
        if stamps:
            _write(mapper, stamps, name, force=parsed.force)
            name, drawn = next(names), drawn + 1
    if not drawn:
        raise MappingError("nothing was met on the way; a map needs a drive with walls or tape")
    return 0


def _written(out: Path) -> tuple[Path, Path, Path]:
    return out, out.with_suffix(".pgm"), out.with_suffix(".tum")


def _names(out: Path, force: bool) -> Iterator[Path]:
    """Yield where the map of each drive in a recording is written; there may be several."""
    yield out
    for number in count(2):
        path = out.with_stem(f"{out.stem}-{number}")
        if force or not any(other.exists() for other in _written(path)):
            yield path


def _write(mapper: CellMapper, stamps: list[float], out: Path, *, force: bool) -> None:
    """Write a map and the robot's path, unless it contradicts itself, and say what they are."""
    grid, path = mapper.grid, out.with_suffix(".tum")
    quality = mapper.quality if isinstance(mapper, GraphSlam) else FitQuality(math.nan)
    quality.require_consistent(force=force)
    save_map_yaml(grid, out)
    if isinstance(mapper, GraphSlam):
        with out.open("a", encoding="utf-8") as file:
            file.write(f"# fit: {json.dumps(quality.table())}\n")
    write_tum(path, Trajectory.of_poses(np.array(stamps), mapper.path, out.stem))
    metres = np.hypot(*np.diff(mapper.path[:, :2], axis=0).T).sum()
    walls = np.count_nonzero(grid.occupied)
    say(f"{len(stamps)} looks along {metres:.1f} m, {walls} cells of {grid.resolution:g} m")
    if isinstance(mapper, GraphSlam):
        for line in (certainty(mapper, stamps), *quality.facts, *quality.remarks):
            say(line)
    say(f"the map is {out}, the robot's path {path}")


def certainty(slam: GraphSlam, stamps: list[float]) -> str:
    """Return a line that says how certain a path is, and where least."""
    sd = slam.position_sd()
    worst = int(np.argmax(sd))
    seconds = stamps[worst] - stamps[0]
    where = f"{WITHIN_95 * sd[worst]:.2f} m (95 %), {seconds:.0f} s after the start"
    if not slam.loops:
        return f"no loop was closed; the path may be off by {where}"
    return f"{slam.loops} matches closed loops; the path is known to {where}, and better elsewhere"


def _mapper(parsed: argparse.Namespace, method: str, laser: bool) -> CellMapper:
    start = Pose2(*parsed.start)
    if method == "graph":
        return GraphSlam(GraphSettings(), start)
    return FastSlam(WALLS if laser else TAPE, start, np.random.default_rng(parsed.seed))


def _draw(
    mapper: CellMapper, first: Observation, looks: Iterator[Observation]
) -> tuple[list[float], Iterator[Observation]]:
    """Draw the looks of a drive.

    Returns:
        Their stamps [s], none if there is nothing to draw; and the looks of the drives after it.
    """
    stamps: list[float] = []
    newest = deque[Observation](maxlen=2 * TORN_AFTER)
    loose: list[int] = []
    has_met, left = False, looks
    for look in chain([first], looks):
        if look.begins and stamps:
            left = chain([look], looks)
            break
        mapper.update(look.moved, look.beams)
        stamps.append(look.stamp)
        newest.append(look)
        has_met |= bool(np.count_nonzero(look.beams.hit) >= FEWEST_MET)
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{len(stamps)} looks are drawn")
        if not isinstance(mapper, GraphSlam) or (torn := mapper.torn()) is None:
            continue
        if not _is_break([*newest]):
            loose.append(torn)
            continue
        mapper.forget_from(torn)
        say(
            f"{stamps[torn] - stamps[0]:.0f} s after the start another map begins: what the laser "
            "sees from there on fits nothing before, so it is another building, or the robot was "
            "carried"
        )
        del stamps[torn:]
        begun, *others = [*newest][TORN_AFTER:]
        left = chain([begun._replace(moved=Pose2(), begins=True)], others, looks)
        break
    if len(stamps) < 2 or not has_met:
        return [], left
    mapper.finish()
    for node in loose:
        if isinstance(mapper, GraphSlam) and not mapper.is_tied(node):
            say(
                f"{stamps[node] - stamps[0]:.0f} s after the start the wheels alone tell how the "
                "map goes on: what the laser sees from there on fits nothing before"
            )
    return stamps, left


def _is_break(looks: list[Observation]) -> bool:
    """Return whether clock or odometry jump at the middle one of some looks."""
    middle = len(looks) // 2
    steps = [math.hypot(look.moved.x, look.moved.y) for look in looks]
    step = steps.pop(middle)
    paused = looks[middle].stamp - looks[middle - 1].stamp > PAUSE_S
    return paused or step > JUMP * max(steps)
