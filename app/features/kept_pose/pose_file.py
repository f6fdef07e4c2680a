"""The file that keeps a pose from one run to the next."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field as PydanticField
from pydantic import ValidationError

from app.files import atomic_file
from app.messages.message import Message
from app.messages.telemetry import HypothesisMessage, PoseMessage
from app.settings.config import Config
from robot.covariance import CovarianceError, covariance_from
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.user_folders import state_folder

LARGEST = 1_000_000
"""A larger file is not a saved pose [bytes]."""


class PoseFileError(BrickPoseError, ValueError):
    """A saved pose that cannot be used; the message says why."""


class SavedPose(Message):
    """The filter's hypotheses at the end of a run, with the map."""

    format: Literal[1] = 1
    map: str
    extent: list[float]
    """Extent of the map; a map of the same name with another extent is another map."""
    hypotheses: Annotated[list[HypothesisMessage], PydanticField(min_length=1, max_length=1000)]
    truth: PoseMessage | None
    """Where a simulated robot really was."""

    def believed(self) -> tuple[Hypothesis, ...]:
        """Return the hypotheses, heaviest first.

        Raises:
            PoseFileError: a covariance is not valid.
        """
        try:
            result = [
                Hypothesis(
                    hypothesis.weight,
                    Pose2(hypothesis.x, hypothesis.y, hypothesis.theta),
                    covariance_from(hypothesis.covariance),
                )
                for hypothesis in self.hypotheses
            ]
        except CovarianceError as error:
            raise PoseFileError(f"its {error}") from error
        return tuple(sorted(result, key=lambda item: -item.weight))


def pose_path(config: Config, field: Field) -> Path:
    """Return the path of the pose file: the named file, else one for each robot and map."""
    if config.start_pose.pose_file:
        return Path(config.start_pose.pose_file).absolute()
    return state_folder() / f"pose-{config.robot}-{field.name}.json"


def write(path: Path, saved: SavedPose) -> None:
    """Write the saved pose, so that the file is complete at any moment.

    Raises:
        OSError: the file cannot be written.
    """
    with atomic_file(path) as new:
        new.write_text(saved.model_dump_json(indent=1), encoding="utf-8")


def read(path: Path, field: Field) -> SavedPose:
    """Read the saved pose for a field.

    Raises:
        PoseFileError: the file is missing, unreadable, too large, damaged, or of another map.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise PoseFileError(f"{path} is too large for a saved pose")
        saved = SavedPose.model_validate_json(path.read_bytes())
    except FileNotFoundError as error:
        raise PoseFileError(f"there is no {path} yet") from error
    except OSError as error:
        raise PoseFileError(f"{path} cannot be read: {error.strerror}") from error
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise PoseFileError(f"{path} is damaged: {where} {first['msg']}".strip()) from error
    _check(saved, path, field)
    return saved


def _check(saved: SavedPose, path: Path, field: Field) -> None:
    if saved.map != field.name or saved.extent != list(field.extent):
        raise PoseFileError(f"{path} is of another map, {saved.map}")
    try:
        believed = saved.believed()
    except PoseFileError as error:
        raise PoseFileError(f"{path} is damaged: {error}") from error
    truth = [] if saved.truth is None else [saved.truth]
    poses = [item.pose for item in believed] + [Pose2(t.x, t.y, t.theta) for t in truth]
    if not all(field.contains(pose) for pose in poses):
        raise PoseFileError(f"{path} is damaged: a pose is off the map")
    if not believed[0].weight > 0:
        raise PoseFileError(f"{path} is damaged: nothing has a weight")
