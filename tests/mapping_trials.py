"""Measures how exact maps are that robots draw: ``python tests/mapping_trials.py square stub``.

Not a test: each drive takes some seconds.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from mappings import eight, errors_of, mapped

from app.settings.config import MAPS
from robot.calibration.adjustment import CalibrationError
from robot.driving.figure_eight import FigureEight
from robot.fields.field_loading import load_field
from robot.mapping.tape_map import MappingError


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("maps", nargs="+", metavar="MAP")
    parser.add_argument("--world", default="default", help="a condition, as of brickpose run")
    parser.add_argument("--laps", type=int, default=1, help="of the figure-eight")
    parser.add_argument("--seeds", type=int, nargs=2, default=(61000, 61024), metavar=("A", "END"))
    given = parser.parse_args()
    seconds = math.ceil(given.laps * FigureEight().lap)
    for name in given.maps:
        taped = load_field(name, MAPS)
        rows = []
        for seed in range(*given.seeds):
            try:
                drawn, poses = mapped(name, seed, given.world, seconds, eight)
            except (CalibrationError, MappingError) as error:
                print(f"{name} {seed}: refused: {error}", flush=True)
                continue
            errors = errors_of(drawn, poses, taped)
            rows.append([1e3 * errors.path, 1e3 * errors.mean, 1e3 * errors.largest])
            print(
                f"{name} {seed}: path {rows[-1][0]:.2f} mm, edges {rows[-1][1]:.2f} mm, largest "
                f"{rows[-1][2]:.1f} mm, {100 * errors.covered:.0f} % of the tape",
                *drawn.remarks,
                sep="; ",
                flush=True,
            )
        for label, value in (("median", np.median), ("worst", np.max)):
            path, mean, largest = value(rows, axis=0)
            print(f"{name}: {label} path {path:.2f}, edges {mean:.2f}, largest {largest:.1f} mm")


if __name__ == "__main__":
    main()
