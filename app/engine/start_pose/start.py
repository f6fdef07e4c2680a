"""Decides where the filter, and a simulated robot, start."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.engine.start_pose.pose_file import PoseFileError, read
from app.languages.marking import phrase
from app.messages.telemetry import PoseMessage
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
    """Why a saved pose was not used."""


def start(settings: StartPoseSettings, path: Path, field: Field) -> Start:
    """Return the saved pose if wanted and usable, else the configured pose, else the field's.

    Raises:
        FieldError: the configured pose is not on the field.
    """
    complaint = None
    if settings.restore_pose:
        try:
            saved = read(path, field)
        except PoseFileError as error:
            complaint = phrase(f"The saved pose is not used: {error}.")
        else:
            return Start(saved.believed(), _pose(saved.truth))
    if not settings.set_initial_pose:
        return Start(complaint=complaint)
    given = settings.initial_pose
    field.require_inside(given.pose)
    return Start((Hypothesis(1.0, given.pose, given.matrix()),), complaint=complaint)


def _pose(pose_message: PoseMessage | None) -> Pose2 | None:
    return (
        None if pose_message is None else Pose2(pose_message.x, pose_message.y, pose_message.theta)
    )
