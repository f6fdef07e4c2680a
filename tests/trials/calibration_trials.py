"""Measures how honest a calibration's intervals are: ``calibration_trials.py circle``.

Not a test: each drive takes some seconds.
"""

from __future__ import annotations

import argparse
import math

import numpy as np
from calibrations import SPEC, START_COVARIANCE, driven, placed

from app.settings.config import MAPS
from robot.calibration.adjustment import CalibrationError
from robot.calibration.calibrate import calibrate
from robot.calibration.programme import velocity
from robot.description.unknowns import ROBOT
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2

TURN = 0.6
"""Turning rate of the figure-eight and of the circle [rad/s]."""


def eight(elapsed: float) -> Twist2:
    return Twist2(0.12, TURN if elapsed % (4 * math.pi / TURN) < 2 * math.pi / TURN else -TURN)


def circle(elapsed: float) -> Twist2:
    return Twist2(0.12, TURN)


def spins(elapsed: float) -> Twist2:
    return Twist2(0.0, 0.8 if elapsed % 20 < 10 else -0.8)


def straights(elapsed: float) -> Twist2:
    return Twist2(0.1 if elapsed % 5 < 2.5 else -0.1, 0.0)


MOTIONS = {
    "usual": velocity,
    "eight": eight,
    "circle": circle,
    "spins": spins,
    "straights": straights,
}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("motion", choices=MOTIONS)
    parser.add_argument("--world", default="hand-built")
    parser.add_argument("--map", default="square")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument(
        "--told-off",
        type=float,
        nargs=3,
        default=(0.0, 0.0, 0.0),
        metavar=("X", "Y", "DEGREES"),
        help="the start is told so far from where it is, and some centimetres and degrees",
    )
    parser.add_argument("--seeds", type=int, nargs=2, default=(740, 748), metavar=("FIRST", "END"))
    given = parser.parse_args()
    taped = load_field(given.map, MAPS)
    x, y, degrees = given.told_off
    off = Pose2(x, y, math.radians(degrees))
    errors = []
    for seed in range(*given.seeds):
        motion = MOTIONS[given.motion]
        log, true, poses = driven(given.world, seed, given.seconds, motion, given.map)
        told = placed(seed, taped)
        told = Pose2(told.x + off.x, told.y + off.y, told.theta + off.theta)
        try:
            found = calibrate(log, SPEC, taped, told, START_COVARIANCE)
        except CalibrationError as error:
            print(f"{seed}: refused: {error}")
            continue
        errors.append(((found.values - true) / found.sd)[:ROBOT])
        away = Pose2.from_array(found.solution.state.poses[0]).distance_to(
            Pose2.from_array(poses[0])
        )
        print(
            f"{seed}: at most {np.abs(errors[-1]).max():.1f} deviations off,",
            f"its start {1e3 * away:.0f} mm",
            *found.remarks,
        )
    share = np.mean(np.abs(errors) < 1.96)
    print(f"{100 * share:.1f} % of the true values lie inside the 95 % intervals")


if __name__ == "__main__":
    main()
