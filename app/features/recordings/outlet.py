"""Records as long as a program runs, lists what was recorded, and shows how a replay stands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import datetime
from functools import partial
from typing import Any

from fastapi import APIRouter

from app.console import say
from app.engine.snapshot import ReplayState, Snapshot
from app.features.recordings.commands import OPENER, RECORDER, REPLAY
from app.features.recordings.contents import contents_of
from app.features.recordings.full_disk import FullDisk
from app.features.recordings.opener import RecordingOpener
from app.features.recordings.recorder import Recorder
from app.features.recordings.replay.opening import ReplayProgram
from app.features.recordings.replay.recorded_robot import replayed
from app.features.recordings.routes import contents_router, recordings_router
from app.features.ros.outlet import publisher_of
from app.messages.telemetry import ReplayMessage
from app.page.outlets import Outlet, Outlets
from app.page.telemetry import pose_message


class RecordingsOutlet(Outlet):
    """Recordings of one program."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare to record."""
        program = self._program = outlets.program
        full = program.handed_on.get("recordings")
        self.recorder = Recorder(
            publisher_of(outlets),
            program.config.recording,
            partial(contents_of, program),
            datetime.now,
            full if isinstance(full, FullDisk) else None,
        )
        self._opener = RecordingOpener(program, self.recorder, outlets.changes)

    @property
    def parts(self) -> Mapping[str, object]:
        """What records, what opens recordings, and what replays."""
        parts = {RECORDER.name: self.recorder, OPENER.name: self._opener}
        replay = (
            {REPLAY.name: program.replay}
            if isinstance(program := self._program, ReplayProgram)
            else {}
        )
        return parts | replay

    @property
    def failures(self) -> Iterable[str]:
        """What is not recorded."""
        problem = self.recorder.problem
        return () if problem is None else (problem,)

    @property
    def handed_on(self) -> FullDisk | None:
        """The disk that was full at the last recording; None if none was."""
        return self.recorder.full_disk

    def routers(self) -> Iterable[APIRouter]:
        """Return the routes of recordings and of their contents."""
        program = self._program
        return (
            recordings_router(program.config.recording.path, replayed(program.robot)),
            contents_router(partial(contents_of, program)),
        )

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return how the recording and the replay stand."""
        program = self._program
        waits = isinstance(program, ReplayProgram) and program.before is not None
        return {
            "recording": self.recorder.status,
            "replay": _replay_message(snapshot.replay, robot_waits=waits),
        }

    def start(self) -> None:
        """Begin to record, if the settings ask for it."""
        if self._program.config.recording.record:
            say(f"Recording to {self.recorder.start()}")

    def close(self) -> None:
        """Wait until the recording is written."""
        self.recorder.close()


def _replay_message(state: ReplayState | None, *, robot_waits: bool) -> ReplayMessage | None:
    if state is None:
        return None
    return ReplayMessage(
        file=state.file,
        position_s=state.position_s,
        duration_s=state.duration_s,
        speed=state.speed,
        paused=state.paused,
        catching_up=state.catching_up,
        estimate_then=pose_message(state.estimate_then),
        robot_waits=robot_waits,
    )
