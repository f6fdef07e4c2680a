"""Keeps the pose of the robot in a file, for the next start."""

from __future__ import annotations

from pathlib import Path

import anyio
import anyio.to_thread

from app.engine.mailboxes.latest import Latest
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.engine.start_pose.pose_file import SavedPose, write
from app.messages.telemetry import HypothesisMessage, PoseMessage
from robot.covariance import by_rows
from robot.fields.field import Field


class PoseKeeper:
    """Writes what the newest snapshot believes; a thread of its own, as a disk may be slow."""

    def __init__(self, path: Path, rate: float, field: Field, latest: Latest[Snapshot]) -> None:
        self.failure: str | None = None
        """Why the last attempt failed."""
        self._path = path
        self._rate = rate
        self._field = field
        self._latest = latest
        self._kept: SavedPose | None = None

    async def follow(self) -> None:
        """Save now and then, until cancelled."""
        while self._rate > 0:
            await anyio.sleep(1 / self._rate)
            await anyio.to_thread.run_sync(self.save)

    def save(self) -> None:
        """Save, if there is something new; a failure is told once, and tried again."""
        snapshot = self._latest.get()
        saved = saved_pose(snapshot, self._field) if snapshot else None
        if saved is None or saved == self._kept or self._rate <= 0:
            return
        try:
            write(self._path, saved)
        except OSError as error:
            if self.failure is None:
                LOG.warning("the pose cannot be saved: %s", error)
            self.failure = f"The pose cannot be saved: {error}"
            return
        self._kept = saved
        self.failure = None


def saved_pose(snapshot: Snapshot, field: Field) -> SavedPose | None:
    """What is worth keeping of a snapshot; None while nothing is known."""
    hypotheses = [
        HypothesisMessage(
            x=pose.x, y=pose.y, theta=pose.theta, weight=weight, covariance=by_rows(covariance)
        )
        for pose, weight, covariance in snapshot.hypotheses()
        if field.contains(pose)
    ]
    if not hypotheses:
        return None
    # Pushed off the field, a robot is nowhere that the file may tell; what it believes is kept.
    truth = snapshot.truth if snapshot.truth and field.contains(snapshot.truth) else None
    return SavedPose(
        map=field.name,
        extent=list(field.extent),
        hypotheses=hypotheses,
        truth=None if truth is None else PoseMessage(x=truth.x, y=truth.y, theta=truth.theta),
    )
