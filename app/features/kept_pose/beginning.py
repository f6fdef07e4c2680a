"""Begins a run where the last one on the same field ended."""

from __future__ import annotations

from app.engine.start import Start
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2


def kept_start(config: Config, field: Field) -> Start | None:
    """Return where the last run on this field ended, if the settings ask for it."""
    if not config.start_pose.restore_pose:
        return None
    # Imported here, as most runs do not ask for it.
    from app.features.kept_pose.pose_file import PoseFileError, pose_path, read  # noqa: PLC0415

    try:
        saved = read(pose_path(config, field), field)
    except PoseFileError as error:
        return Start(complaint=phrase(f"The saved pose is not used: {error}."))
    if saved.truth is None:
        return Start(saved.believed())
    return Start(saved.believed(), Pose2(saved.truth.x, saved.truth.y, saved.truth.theta))
