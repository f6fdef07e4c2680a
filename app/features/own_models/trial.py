"""A trial of a sensor model before it is used: does it prefer the place where a scan was taken?

Scans without noise are made at known poses of the field. A model that rates a place beside such a
pose about as high finds no robot, though all its numbers may be valid ones: it returns a constant,
takes degrees for radians, or forgets the logarithm.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from app.features.own_models.guards import OwnSensor
from app.languages.marking import phrase
from robot.fields.field import Field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, compose
from robot.scan import Scan

BEARINGS = np.linspace(-0.5, 0.5, 31)
REACH = 1.0
"""How far the rays see [m]."""
FEWEST_RETURNS = 8
"""Where fewer rays meet tape, a scan says too little."""
ASIDE = np.array(
    [[0.05, 0, 0], [-0.05, 0, 0], [0, 0.05, 0], [0, -0.05, 0], [0, 0, 0.4], [0, 0, -0.4]]
)
"""Places beside the true one, seen from there [m, m, rad]."""
TELLING = 0.01
"""Places are told apart by a scan whose ranges differ by more than this in the mean [m]."""
MOST_COUNTED = 0.05
"""A range that differs by more counts as this much [m]: one ray alone tells little."""
WORSE = 2.0
"""A place beside the true one should be rated worse by at least this: 7 times less likely."""
ALLOWED = 0.25
"""A good model fails in a few of a hundred trials; one that exchanges x and y in every second."""
LONGEST_S = 0.2
"""A slow model is asked no longer: the robot waits meanwhile [s]."""


def doubt_of(sensor: OwnSensor, field: Field) -> str | None:
    """Return in words that a model does not prefer the true place; None if it mostly does."""
    ends = time.perf_counter() + LONGEST_S
    lead: list[float] = []
    for pose in _places(field):
        if time.perf_counter() < ends and sensor.guard.fault is None:
            lead += _leads(sensor, field, pose)
    worse = [each for each in lead if each < WORSE]
    if sensor.guard.fault is not None or len(worse) <= ALLOWED * len(lead):
        return None
    count, trials, least = len(worse), len(lead), WORSE
    return phrase(
        f"In {count} of {trials} trials the model rates a place 50 mm or 23° beside the true one "
        f"as likely, or nearly so: the log-likelihood should be less by {least} or more."
    )


def judge_on(field: Field) -> Callable[[OwnSensor], str | None]:
    """Return what tries sensor models on a field."""
    return lambda sensor: doubt_of(sensor, field)


def _places(field: Field) -> list[Pose2]:
    """Return poses around the field's start, in four directions, that are inside."""
    steps = [Pose2(x, y, 0.3) for x, y in ((0.0, 0.0), (0.12, 0.07), (-0.1, 0.09))]
    turns = [Pose2(0.0, 0.0, quarter * np.pi / 2) for quarter in range(4)]
    poses = [field.start @ turn @ step for step in steps for turn in turns]
    return [pose for pose in poses if field.contains(pose)]


def _leads(sensor: OwnSensor, field: Field, pose: Pose2) -> list[float]:
    """Return by how much the true place is rated higher than each that the scan tells from it."""
    poses = np.vstack([pose.to_array(), compose(np.tile(pose.to_array(), (6, 1)), ASIDE)])
    ranges = np.empty((len(poses), len(BEARINGS)))
    cast_rays(poses, BEARINGS, field.edge_index, REACH, ranges)
    if np.isfinite(ranges[0]).sum() < FEWEST_RETURNS:
        return []
    sight = np.tile([0.0, REACH], (len(BEARINGS), 1))
    rated = sensor.log_likelihood(poses, Scan(0.0, BEARINGS, ranges[0], sight=sight))
    return [float(lead) for lead in (rated[0] - rated[1:])[_distinguishable(ranges)]]


def _distinguishable(ranges: Array) -> Array:
    """Return which of the places (6,) have ranges other than the first's."""
    known = np.minimum(ranges, REACH)
    apart = np.minimum(np.abs(known[1:] - known[0]), MOST_COUNTED)
    differs: Array = apart.mean(axis=1) > TELLING
    return differs
