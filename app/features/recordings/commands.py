"""Commands that record, and that change how a recording is replayed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.engine.command_row import CommandRow, Part, Request
from app.engine.program import Program
from app.features.recordings.messages import (
    CloseRecordingCommand,
    OpenRecordingCommand,
    RecordCommand,
    ReplayCommand,
    RunAgainCommand,
)
from robot.errors import CommandError

if TYPE_CHECKING:
    from app.features.recordings.opener import RecordingOpener
    from app.features.recordings.recorder import Recorder
    from app.features.recordings.replay.replay import Replay

OPENER: Part[RecordingOpener] = Part("opener of recordings")
RECORDER: Part[Recorder] = Part("recorder")
REPLAY: Part[Replay] = Part("replay")


def require_replay(program: Program) -> None:
    """Refuse what only a replay does."""
    if program.loop is None:
        raise CommandError("this is no replay; brickpose replay FILE starts one")


def _record(request: Request[RecordCommand]) -> None:
    recorder = request.part(RECORDER)
    if request.command.on:
        recorder.start()
    else:
        recorder.stop()


def _replay(request: Request[ReplayCommand]) -> None:
    command = request.command
    request.part(REPLAY).asked.ask(command.paused, command.speed, command.position_s, command.step)


def _open(request: Request[OpenRecordingCommand]) -> None:
    request.part(OPENER).open(request.driver, request.command.name)


def _run_again(request: Request[RunAgainCommand]) -> None:
    request.part(OPENER).run_again(request.driver)


def _close(request: Request[CloseRecordingCommand]) -> None:
    request.part(OPENER).close()


COMMANDS = (
    CommandRow(RecordCommand, act=_record),
    CommandRow(ReplayCommand, act=_replay, allowed=require_replay),
    CommandRow(OpenRecordingCommand, act=_open, slow=True),
    CommandRow(RunAgainCommand, act=_run_again, slow=True),
    CommandRow(
        CloseRecordingCommand,
        act=_close,
        allowed=require_replay,
        slow=True,
        after_failure=True,
    ),
)
