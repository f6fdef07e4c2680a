"""Decides where the filter, and a simulated robot, start."""

from __future__ import annotations

from dataclasses import dataclass

from app.settings.groups import StartPoseSettings
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis


@dataclass(frozen=True, slots=True)
class Start:
    """Where a run begins."""

    hypotheses: tuple[Hypothesis, ...] = ()
    """Start of the filter; empty is the field's start with the filter's own spread."""
    truth: Pose2 | None = None
    """Start of a simulated robot."""
    odometry: Pose2 | None = None
    """Where dead reckoning begins; None is as far as the rest tells it."""
    complaint: str | None = None
    """What of a feature was asked for and could not be used, as a saved pose; for people."""


def start(settings: StartPoseSettings, field: Field) -> Start:
    """Return the configured pose, else the field's.

    Raises:
        FieldError: the configured pose is not on the field.
    """
    if not settings.set_initial_pose:
        return Start()
    given = settings.initial_pose
    field.require_inside(given.pose)
    return Start((Hypothesis(1.0, given.pose, given.matrix()),))
