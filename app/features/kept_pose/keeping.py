"""Saves the robot's pose in a file, and starts the next run from it."""

from __future__ import annotations

import threading
from collections.abc import Iterable

from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.engine.start import Start
from app.features.kept_pose.pose_file import PoseFileError, SavedPose, pose_path, read, write
from app.languages.marking import phrase
from app.messages.telemetry import HypothesisMessage, PoseMessage
from app.page.outlets import Outlet, Outlets
from app.settings.config import Config
from robot.covariance import by_rows
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.worker_thread import WorkerThread

JOIN_S = 5.0
"""How long the end waits for a disk [s]."""


class PoseKeeper(Outlet):
    """Saves the hypotheses of the newest snapshot, in another thread, as a disk may be slow."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare to save where the settings say, as often as they say."""
        program = outlets.program
        self.failure: str | None = None
        """Why the last attempt failed; None if it did not."""
        self._path = pose_path(program.config, program.field)
        self._rate = program.config.start_pose.save_pose_rate
        self._field = program.field
        self._latest = program.engine.latest
        self._kept: SavedPose | None = None
        self._thread = WorkerThread("pose", self._follow, owner="the kept pose", patience=JOIN_S)

    @property
    def failures(self) -> Iterable[str]:
        """Why the last attempt failed."""
        return () if self.failure is None else (self.failure,)

    def start(self) -> None:
        """Save at the configured rate, until it is closed."""
        if self._rate > 0:
            self._thread.start()

    def close(self) -> None:
        """Save a last time; the engine has stopped."""
        self._thread.stop()
        self.save()

    def save(self) -> None:
        """Save if something is new; log the first of several failures, and try again next time."""
        snapshot = self._latest.get()
        saved = saved_pose(snapshot, self._field) if snapshot else None
        if saved is None or saved == self._kept or self._rate <= 0:
            return
        try:
            write(self._path, saved)
        except OSError as error:
            if self.failure is None:
                LOG.warning("the pose cannot be saved: %s", error)
            self.failure = phrase(f"The pose cannot be saved: {error}")
            return
        self._kept = saved
        self.failure = None

    def _follow(self, stopping: threading.Event) -> None:
        while not stopping.wait(1 / self._rate):
            self.save()


def kept_start(config: Config, field: Field) -> Start | None:
    """Return where the last run on this field ended, if the settings ask for it."""
    if not config.start_pose.restore_pose:
        return None
    try:
        saved = read(pose_path(config, field), field)
    except PoseFileError as error:
        return Start(complaint=phrase(f"The saved pose is not used: {error}."))
    if saved.truth is None:
        return Start(saved.believed())
    return Start(saved.believed(), Pose2(saved.truth.x, saved.truth.y, saved.truth.theta))


def saved_pose(snapshot: Snapshot, field: Field) -> SavedPose | None:
    """Return what to save of a snapshot; None while it has no hypothesis on the field."""
    hypotheses = [
        HypothesisMessage(
            x=pose.x, y=pose.y, theta=pose.theta, weight=weight, covariance=by_rows(covariance)
        )
        for pose, weight, covariance in snapshot.hypotheses()
        if field.contains(pose)
    ]
    if not hypotheses:
        return None
    # The file must not hold a pose off the field: leave out such a truth, keep the hypotheses.
    truth = snapshot.truth if snapshot.truth and field.contains(snapshot.truth) else None
    return SavedPose(
        map=field.name,
        extent=list(field.extent),
        hypotheses=hypotheses,
        truth=None if truth is None else PoseMessage(x=truth.x, y=truth.y, theta=truth.theta),
    )
