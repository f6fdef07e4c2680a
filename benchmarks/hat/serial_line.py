"""Benchmark of the paper's recovery over the serial line: emulator, pseudo-terminal and program.

Two processes run as on two computers: `brickpose emulate-hat` turns pybullet's wheels and shows the
floor, and `brickpose run --robot buildhat` drives it. This process, a third one, gives the program
a wrong pose.
"""

from __future__ import annotations

import json
import math
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar
from websockets.sync.connection import Connection

from app.features.lab.evaluation.runs import time_to_converge
from app.features.lab.trajectories.metrics import ate_rmse
from app.trajectories.trajectory import Trajectory
from benchmarks.hat.emulated_hat import EmulatedHat
from benchmarks.hat.programs import robot_in_bricks
from benchmarks.programs import START_S, ServedProgram, connected, estimated, telemetry, until
from benchmarks.result import Result
from robot.geometry import Array, Pose2, wrap_angle

SEEDS = range(12)
WRONG = Pose2(-0.1, -0.1, 0.3)
"""Error of the given pose, in the map's axes, as in the paper [m, m, rad]."""

WATCHED_S = 12.0
SETTLED_S = 2.0
"""Time after the wrong pose before errors count [s]."""

RENEW_S = 0.2

NEAR_S = 0.1
"""How far the offset of the least error may be from the best of those tried first [s]."""

GAP_S = 0.2
"""Longest time between two true poses over which the truth is interpolated [s]."""

POSES = ((1, 2, 3), (4, 5, 6))
"""Columns of the estimate and of the odometry in the recorded telemetry."""


@dataclass(frozen=True)
class SerialRun:
    """One robot's run."""

    seconds: float
    """Time until the estimate is within 20 mm and 0.1 rad for a second [s]; inf if never."""
    error: float
    """Root mean square distance from the truth afterwards [m]."""
    odometry_error: float
    """The same for dead reckoning alone [m]."""


def measure() -> Result:
    """Measure twelve robots, one after the other."""
    drives = [drive(seed) for seed in SEEDS]
    seconds = [run.seconds for run in drives]
    return Result(
        unit="of 12 right again within 4 s",
        brickpose=sum(duration <= 4 for duration in seconds),
        more={
            "right again, median [s]": float(np.median(seconds)),
            "right again, worst [s]": max(seconds),
            "error afterwards, median [mm]": 1e3 * float(np.median([d.error for d in drives])),
            "error afterwards, worst [mm]": 1e3 * max(d.error for d in drives),
            "odometry alone, median [mm]": 1e3
            * float(np.median([d.odometry_error for d in drives])),
        },
    )


def drive(seed: int, watched: float = WATCHED_S) -> SerialRun:
    """Drive one robot on the square; it gets a wrong pose at the start of the figure-eight."""
    with (
        tempfile.TemporaryDirectory() as folder,
        robot_in_bricks(Path(folder), seed) as (hat, server),
    ):
        truth, reports = _watch(hat, server, watched)
    return _judged(truth, reports)


def _watch(hat: EmulatedHat, server: ServedProgram, watched: float) -> tuple[Array, Array]:
    """Return true poses (n, 4) by the emulator's clock, and estimates and odometry by the robot's.

    The latter are (m, 7).
    """
    truth: list[list[float]] = []
    reports: list[list[float]] = []
    with server.live() as socket:
        until(socket, connected, START_S)
        begin = until(socket, estimated, START_S)["stamp"]
        _, (x, y, theta) = hat.pose()
        wrong = {"x": x + WRONG.x, "y": y + WRONG.y, "theta": theta + WRONG.theta}
        _send(socket, type="set_pose", **wrong)
        renewed = -math.inf
        while True:
            if time.monotonic() - renewed > RENEW_S:
                renewed = time.monotonic()
                _send(socket, type="figure_eight")
            stamp, pose = hat.pose()
            if not truth or stamp > truth[-1][0]:
                truth.append([stamp, *pose])
            message = telemetry(socket)
            if message["estimate"] is not None:
                reports.append(
                    [message["stamp"], *_pose(message["estimate"]), *_pose(message["odometry"])]
                )
            if message["stamp"] > begin + watched:
                return np.array(truth), np.array(reports)


def _send(socket: Connection, **command: object) -> None:
    socket.send(json.dumps(command))


def _pose(pose: dict[str, float]) -> list[float]:
    return [pose["x"], pose["y"], pose["theta"]]


def _judged(truth: Array, reports: Array) -> SerialRun:
    """Compare at the clock offset of the least error, as the programs have no common clock.

    Both are in the map's frame and are not aligned: on one circle of the figure-eight, a turned
    path fits as well as a later one. The offset may hide up to the error along the path.
    """
    true, estimate = _planar(truth), _planar(reports[:, [0, *POSES[0]]])
    late = _planar(reports[reports[:, 0] > reports[0, 0] + SETTLED_S])

    def error(offset: float) -> float:
        return ate_rmse(*_paired(true, late.shifted(offset)))

    # Both were watched at the same time, so the later part of one lies within the other.
    first, last = true.stamps[[0, -1]] - late.stamps[[0, -1]]
    near = min(np.arange(first - NEAR_S, last + NEAR_S, NEAR_S / 4).tolist(), key=error)
    offset = float(minimize_scalar(error, bounds=(near - NEAR_S, near + NEAR_S)).x)
    where, matched = _paired(true, estimate.shifted(offset))
    apart = matched.poses - where.poses
    seconds = time_to_converge(
        where.stamps, np.hypot(apart[:, 0], apart[:, 1]), np.array(wrap_angle(apart[:, 2]))
    )
    odometry = _planar(reports[:, [0, *POSES[1]]])
    settled = estimate.stamps[0] + offset + SETTLED_S
    return SerialRun(
        seconds,
        _error_after(settled, true, estimate.shifted(offset)),
        _error_after(settled, true, odometry.shifted(offset)),
    )


def _error_after(stamp: float, truth: Trajectory, estimate: Trajectory) -> float:
    """Return the root mean square distance [m] after a time."""
    where, matched = _paired(truth, estimate)
    later = where.stamps > stamp
    return ate_rmse(where.selected(later), matched.selected(later))


def _paired(truth: Trajectory, estimate: Trajectory) -> tuple[Trajectory, Trajectory]:
    """Return the truth at the estimate's stamps, and the estimate where the truth is known."""
    stamps = truth.stamps
    after = np.clip(np.searchsorted(stamps, estimate.stamps), 1, len(stamps) - 1)
    known = (estimate.stamps >= stamps[0]) & (estimate.stamps <= stamps[-1])
    known &= stamps[after] - stamps[after - 1] <= GAP_S
    matched = estimate.selected(known)
    x, y, theta = truth.poses.T
    poses = [np.interp(matched.stamps, stamps, axis) for axis in (x, y, np.unwrap(theta))]
    return _planar(np.column_stack([matched.stamps, *poses])), matched


def _planar(rows: Array) -> Trajectory:
    return Trajectory.of_poses(rows[:, 0], rows[:, 1:4])
