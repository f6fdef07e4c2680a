"""Saves the robot's pose in a file, for the next start."""

from __future__ import annotations

from pathlib import Path

import anyio
import anyio.to_thread

from app.engine.mailboxes.latest import Latest
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.engine.start_pose.pose_file import SavedPose, write
from app.languages.marking import phrase
from app.messages.telemetry import HypothesisMessage, PoseMessage
from robot.covariance import by_rows
from robot.fields.field import Field


class PoseKeeper:
    """Saves the hypotheses of the newest snapshot, in another thread, as a disk may be slow."""

    def __init__(self, path: Path, rate: float, field: Field, latest: Latest[Snapshot]) -> None:
        self.failure: str | None = None
        """Why the last attempt failed; None if it did not."""
        self._path = path
        self._rate = rate
        self._field = field
        self._latest = latest
        self._kept: SavedPose | None = None

    async def follow(self) -> None:
        """Save at the configured rate, until cancelled."""
        while self._rate > 0:
            await anyio.sleep(1 / self._rate)
            await anyio.to_thread.run_sync(self.save)

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
