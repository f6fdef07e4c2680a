"""The filter's claims at each picture of a drive, and the truth; as CSV for others too."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from app.engine.localization import Localization
from app.features.lab.evaluation.drives import Drive, EvaluationError, Tick, follow_drive
from app.features.lab.evaluation.experiment import KNOWN, OFFSET
from app.features.lab.evaluation.integrity.drives import TrialDrive
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.estimate import Cause, Integrity, State
from robot.localization.models.entry_field import EntryField

STARTS = (
    "known", "told-wrong", "told-quarter", "scattered", "carried", "known-carried", "moved",
)  # fmt: skip
"""What the filter knows at the start: the true pose, give or take 1 cm and 0.03 rad; a pose that
is 0.14 m and 0.3 rad off; one that is turned by a quarter about the tape's middle; nothing; nothing
or the true pose, with the robot carried off later while it drives; and the true pose, with the
robot moved a little while it stands."""

TOLD = 8
"""Number of the random stream, beside the seed, that the error of a known start is drawn from."""
_ENTRIES: dict[tuple[bytes, float, float], EntryField] = {}
COLUMNS = (
    "stamp", "true_x", "true_y", "true_theta", "x", "y", "theta",
    "state", "radius", "heading_bound", "weight",
)  # fmt: skip
"""Seconds, metres, radians; the pose is the estimate at the picture's stamp, nan without one; the
radius is inf without a bound."""
STATE = COLUMNS.index("state")


@dataclass(frozen=True, eq=False)
class Claims:
    """The claims and the truth at n pictures, in order."""

    stamps: Array
    """(n,) [s]"""
    truth: Array
    """(n, 3) [m, m, rad] in the map."""
    poses: Array
    """(n, 3) the estimates at the pictures' stamps; nan where there is none."""
    covariance: Array
    """(n, 3, 3) [m, m, rad], of the heaviest hypothesis; nan where there is none."""
    weights: Array
    """(n,) of the heaviest hypothesis."""
    states: tuple[State, ...]
    radius: Array
    """(n,) [m]"""
    heading_bound: Array
    """(n,) [rad]"""
    causes: tuple[Cause | None, ...]
    """The likeliest reason for doubt at each picture; None without one."""
    carry_stamp: float | None
    """When the robot was carried off [s]."""

    @property
    def errors(self) -> Array:
        """(n, 3) estimate minus truth [m, m, rad]; nan without an estimate."""
        offset = self.poses - self.truth
        offset[:, 2] = wrap_angle(offset[:, 2])
        return offset

    @property
    def distances(self) -> Array:
        """(n,) from the truth [m]; inf without an estimate."""
        result: Array = np.nan_to_num(np.hypot(*self.errors[:, :2].T), nan=math.inf)
        return result

    @property
    def turns(self) -> Array:
        """(n,) from the true heading [rad], absolute; inf without an estimate."""
        result: Array = np.nan_to_num(np.abs(self.errors[:, 2]), nan=math.inf)
        return result


@dataclass(frozen=True, slots=True, eq=False)
class _Row:
    stamp: float
    truth: Pose2
    pose: Pose2 | None
    covariance: Array
    weight: float
    integrity: Integrity


def follow_claims(trial: TrialDrive, config: Config, start: str) -> Claims:
    """Let the program's localization follow a drive, and keep its claims.

    Args:
        trial: what the robot saw and where it was.
        config: seed, localization and the user's own models.
        start: one of ``STARTS``.

    Raises:
        EvaluationError: one of the user's own models is broken, or there are fewer than three
            pictures.
    """
    field = trial.drive.field
    following = follow_drive(
        trial.drive,
        config,
        lambda localization: _STARTERS[start](localization, trial.drive, config),
        believed=field,
        entries=entries_over(field, config),
    )
    rows = [_claim(localization, trial.drive, tick) for tick, _, localization in following]
    if len(rows) < 3:
        raise EvaluationError("fewer than three pictures were taken; drive for longer")
    return _claims(rows, trial.carry_stamp)


def entries_over(field: Field, config: Config) -> EntryField:
    """Return the distance table of a field.

    The table takes long to build, so each process keeps the last one.
    """
    sensor = config.localization.sensor
    far = sensor.laser_likelihood_max_dist
    key = field.edges.tobytes(), sensor.field_resolution, far
    if key not in _ENTRIES:
        _ENTRIES.clear()
        resolution = sensor.field_resolution
        _ENTRIES[key] = EntryField.build(field, resolution=resolution, max_distance=far)
    return _ENTRIES[key]


def _tell_known(localization: Localization, drive: Drive, config: Config) -> None:
    rng = np.random.default_rng([config.seed, TOLD])
    error = rng.normal(0, np.sqrt(np.diag(KNOWN)))
    localization.set_pose(_beside(drive.ticks[0].truth, error), KNOWN)


def _tell_wrong(localization: Localization, drive: Drive, _config: Config) -> None:
    localization.set_pose(_beside(drive.ticks[0].truth, np.array(OFFSET)))


def _tell_quarter(localization: Localization, drive: Drive, _config: Config) -> None:
    localization.set_pose(quarter_off(drive.ticks[0].truth, drive.field))


def quarter_off(pose: Pose2, field: Field) -> Pose2:
    """Return a pose turned by a quarter about the middle of the tape."""
    xmin, ymin, xmax, ymax = field.drive_area
    middle = Pose2((xmin + xmax) / 2, (ymin + ymax) / 2)
    return middle @ Pose2(theta=math.pi / 2) @ middle.inverse() @ pose


def _tell_nothing(localization: Localization, _drive: Drive, _config: Config) -> None:
    localization.scatter()


_STARTERS: dict[str, Callable[[Localization, Drive, Config], None]] = {
    "known": _tell_known,
    "told-wrong": _tell_wrong,
    "told-quarter": _tell_quarter,
    "scattered": _tell_nothing,
    "carried": _tell_nothing,
    "known-carried": _tell_known,
    "moved": _tell_known,
}


def _beside(pose: Pose2, offset: Array) -> Pose2:
    dx, dy, turn = offset.tolist()
    return replace(pose, x=pose.x + dx, y=pose.y + dy, theta=pose.theta + turn)


def _claim(localization: Localization, drive: Drive, tick: Tick) -> _Row:
    assert tick.scan is not None and tick.odometry_at_scan is not None
    belief, stamp = localization.belief, tick.scan.stamp
    truth = drive.truth_at(stamp)
    if belief is None:
        return _Row(stamp, truth, None, np.full((3, 3), np.nan), 0.0, localization.integrity)
    best = belief.estimate.hypotheses[0]
    pose = belief.pose(tick.odometry_at_scan)
    return _Row(stamp, truth, pose, best.covariance, best.weight, localization.integrity)


def _claims(rows: list[_Row], carry_stamp: float | None) -> Claims:
    nowhere = np.full(3, np.nan)
    claimed = [row.integrity for row in rows]
    return Claims(
        np.array([row.stamp for row in rows]),
        np.array([row.truth.to_array() for row in rows]),
        np.array([nowhere if row.pose is None else row.pose.to_array() for row in rows]),
        np.array([row.covariance for row in rows]),
        np.array([row.weight for row in rows]),
        tuple(claim.state for claim in claimed),
        np.array([claim.radius for claim in claimed]),
        np.array([each.heading_bound for each in claimed]),
        tuple(item.alerts[0].cause if item.alerts else None for item in claimed),
        carry_stamp,
    )


def claims_csv(claims: Claims) -> str:
    """Return the claims as CSV, one line for each picture."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    numbers = np.column_stack([claims.stamps, claims.truth, claims.poses])
    bounds = np.column_stack([claims.radius, claims.heading_bound, claims.weights])
    for before, state, after in zip(numbers, claims.states, bounds, strict=True):
        writer.writerow([*map(_short, before), str(state), *map(_short, after)])
    return text.getvalue()


def read_numbers(path: Path) -> dict[str, Array]:
    """Read the numeric columns by name, each (n,)."""
    wanted = [place for place in range(len(COLUMNS)) if place != STATE]
    rows = np.loadtxt(path, delimiter=",", skiprows=1, usecols=wanted, ndmin=2)
    return {COLUMNS[place]: column for place, column in zip(wanted, rows.T, strict=True)}


def _short(value: float) -> str:
    """Format a value to a micrometre, a microradian or a microsecond."""
    return f"{value:.6f}"
