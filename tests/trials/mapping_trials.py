"""Measures how exact maps are that robots draw: ``mapping_trials.py square stub``.

Not a test: each drive takes some seconds.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from pathlib import Path

import numpy as np
from calibrations import SPEC
from engine_runs import EIGHT
from mappings import Loop, Tour, errors_of, field_of, held, laid_on, mapped, square_of
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from app.engine.build import Streams, build_program
from app.engine.robots import build_robot
from app.settings.conditions import apply_condition
from app.settings.config import MAPS, Config
from robot.calibration.adjustment import CalibrationError
from robot.driving.figure_eight import FigureEight
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.mapping.tape_map import MappingError, TapeMap
from sim.simulated import PERIOD, no_wait

LONGEST_S = 300.0
"""Of a tour [s]."""
SETTLED_S = 3.0
"""The start is told with an error, which the filter needs so long to see [s]."""


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("maps", nargs="*", metavar="MAP")
    parser.add_argument("--world", default="default", help="a condition, as of brickpose run")
    parser.add_argument("--calibrate", action="store_true", help="the robot along with the map")
    parser.add_argument(
        "--localize", action="store_true", help="another drive in the map, and in the true one"
    )
    parser.add_argument("--tour", action="store_true", help="over all of the field, not the eight")
    parser.add_argument(
        "--loop", type=float, metavar="SIDE", help="once around a square of tape of a side [m]"
    )
    parser.add_argument("--laps", type=int, default=1, help="of the figure-eight")
    parser.add_argument("--seeds", type=int, nargs=2, default=(61000, 61024), metavar=("A", "END"))
    parser.add_argument("--figure", type=Path, help="draws each map's first robot and the truth")
    given = parser.parse_args()
    if given.loop is not None:
        given.maps.append(loop_map(given.loop))
    panels, means, within = {}, [], []
    seconds = math.ceil(given.laps * FigureEight().lap)
    for name in given.maps:
        taped = load_field(name, MAPS)
        rows, others = [], []
        for seed in range(*given.seeds):
            tour = route(taped, given)
            try:
                drawn, poses = mapped(
                    name,
                    seed,
                    given.world,
                    LONGEST_S if tour is not None else seconds,
                    calibrate=given.calibrate,
                    steer=tour,
                )
            except (CalibrationError, MappingError) as error:
                print(f"{name} {seed}: refused: {error}", flush=True)
                continue
            panels.setdefault(name, (taped, drawn, poses))
            errors = errors_of(drawn, poses, taped)
            within.append(held(drawn, poses, taped))
            rows.append([1e3 * errors.path, 1e3 * errors.mean, 1e3 * errors.largest])
            print(
                f"{name} {seed}: path {rows[-1][0]:.2f} mm, edges {rows[-1][1]:.2f} mm, largest "
                f"{rows[-1][2]:.1f} mm, {100 * errors.covered:.0f} % of the tape",
                *drawn.remarks,
                "" if drawn.fits else "it does not fit",
                sep="; ",
                flush=True,
            )
            if given.localize:
                own, true = (
                    1e3 * localized(taped, field, laid, given.world, seed)
                    for field, laid in (
                        (field_of(drawn), laid_on(drawn, poses, taped)),
                        (taped, Pose2()),
                    )
                )
                print(f"    error of another drive {own:.2f} mm; in the true map {true:.2f} mm")
                others.append([own, true])
        if others:
            own, true = np.median(others, axis=0)
            print(
                f"{name}: median error in the own map {own:.2f} mm, in the true one {true:.2f} mm"
            )
        means.append(np.median(rows, axis=0)[1] if rows else math.nan)
        for label, value in (("median", np.median), ("worst", np.max)):
            path, mean, largest = value(rows, axis=0)
            print(f"{name}: {label} path {path:.2f}, edges {mean:.2f}, largest {largest:.1f} mm")
    print(f"median over {len(means)} fields of the mean error: {np.nanmedian(means):.2f} mm")
    if within:
        share = 100 * np.concatenate(within).mean()
        print(f"95 % intervals hold {share:.1f} % of the true edges, in the frame of the start")
    if given.figure:
        draw(panels, given.figure)


def loop_map(side: float) -> str:
    """The file of a square of tape with a side [m]."""
    path = Path(tempfile.mkdtemp()) / "loop.svg"
    path.write_text(square_of(side))
    return str(path)


def route(taped: Field, given: argparse.Namespace) -> Tour | None:
    """What steers the robot; None for the figure-eight."""
    if given.loop is not None:
        return Loop(given.loop)
    return Tour(taped, given.laps) if given.tour else None


def localized(taped: Field, field: Field, floor_from_field: Pose2, world: str, seed: int) -> float:
    """Root mean square of a drive's error on a taped floor, localized in a field [m]."""
    config = apply_condition(Config(robot="sim", seed=seed + 500_000), world)
    robot = build_robot(config, SPEC, taped, Streams.of(config.seed).robot, no_wait)
    program = build_program(config, robot=robot, field=field)
    errors = []
    try:
        for _ in range(round(FigureEight().lap / PERIOD)):
            program.engine.commands.put(EIGHT)
            snapshot = program.engine.step()
            pose, truth = snapshot.pose, snapshot.reading.truth
            if pose is not None and truth is not None and snapshot.stamp > SETTLED_S:
                errors.append((floor_from_field @ pose).distance_to(truth))
    finally:
        robot.close()
    return float(np.sqrt(np.mean(np.square(errors))))


def draw(panels: dict[str, tuple[Field, TapeMap, Array]], out: Path) -> None:
    figure = Figure(figsize=(3.6 * len(panels), 4.2), layout="constrained")
    for place, (name, (taped, drawn, poses)) in enumerate(panels.items(), start=1):
        axes = figure.add_subplot(1, len(panels), place, title=name, aspect="equal")
        floor_from_map = laid_on(drawn, poses, taped)
        path = floor_from_map.apply(drawn.solution.state.poses[:, :2])
        for edges, colour, width, label in (
            (taped.edges, "#bbbbbb", 3.0, "true edges"),
            (_moved(field_of(drawn).edges, floor_from_map), "#d55e00", 0.8, "map"),
        ):
            lines = LineCollection(edges.reshape(-1, 2, 2), colors=colour, linewidths=width)
            lines.set_label(label)
            axes.add_collection(lines)
        axes.plot(*path.T, color="#0072b2", linewidth=0.8, label="path")
        axes.autoscale()
        axes.set_xlabel("x [m]")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    figure.savefig(out, dpi=100)


def _moved(edges: Array, pose: Pose2) -> Array:
    return np.hstack([pose.apply(edges[:, :2]), pose.apply(edges[:, 2:])])


if __name__ == "__main__":
    main()
