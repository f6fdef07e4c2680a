"""Opens a recording in place of the robot, and goes back to the robot."""

from __future__ import annotations

from app.engine.driver import Driver
from app.engine.program import Program
from app.features.recordings.library import find
from app.features.recordings.recorder import Recorder
from app.features.recordings.replay.opening import ReplayProgram
from app.features.recordings.replay.succession import replay_after, robot_again, run_again
from app.page.program_changes import ProgramChanges
from robot.errors import CommandError


class RecordingOpener:
    """Ends a program for the replay of a recording, and the replay for the robot."""

    def __init__(self, program: Program, recorder: Recorder, changes: ProgramChanges) -> None:
        """Prepare to open recordings.

        Args:
            program: the program.
            recorder: records it.
            changes: switches to another program.
        """
        self._program = program
        self._recorder = recorder
        self._changes = changes

    def open(self, driver: Driver, name: str) -> None:
        """Replay a recording in place of the robot.

        Raises:
            BrickPoseError: it cannot be replayed, another client drives, or a map would be lost.
        """
        if self._changes.go_on is None:
            raise CommandError("this program cannot open a recording; brickpose replay does")
        self._changes.require_idle(driver)
        item = find(self._program.config.recording.path(), name)
        following = replay_after(self._program, item.file.parent)
        following.replay.begin()
        self._changes.go_on(lambda: following)

    def run_again(self, driver: Driver) -> None:
        """Replay the last recording with the current parameters; a running recording ends first.

        Raises:
            BrickPoseError: nothing was recorded; also the errors of ``open``.
        """
        if self._changes.go_on is None or self._recorder.folder is None:
            raise CommandError("nothing is recorded of this drive; record, drive, and run it again")
        self._changes.require_idle(driver)
        self._recorder.close()
        following = run_again(self._program, self._recorder.folder)
        following.replay.begin()
        self._changes.go_on(lambda: following)

    def close(self) -> None:
        """Go back to the robot that the recording was opened from.

        Raises:
            CommandError: this program began with the recording.
        """
        program = self._program
        before = program.before if isinstance(program, ReplayProgram) else None
        if before is None or self._changes.go_on is None:
            raise CommandError("there is no robot to go back to; brickpose run starts one")
        self._changes.go_on(lambda: robot_again(program, before))
