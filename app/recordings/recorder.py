"""Starts and ends recordings."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from app.messages.telemetry import RecordingMessage
from app.recordings.attachments import Contents
from app.recordings.files.recorded import RecordingError
from app.recordings.files.recording_file import free_folder
from app.recordings.run import RecordingRun
from app.ros2.publisher import TopicPublisher
from app.settings.recording import RecordingSettings


class Recorder:
    """Makes one recording at a time; for any thread."""

    def __init__(
        self,
        publisher: TopicPublisher,
        settings: RecordingSettings,
        contents: Callable[[], Contents],
        today: Callable[[], datetime],
    ) -> None:
        """Prepare to record; nothing is recorded before ``start``.

        Args:
            publisher: where messages come from.
            settings: where recordings go, and how much is in them.
            contents: returns the facts and files for the beginning of each recording; called in
                the recording's own thread.
            today: returns the date and time of the wall clock, for the names of recordings.
        """
        self.settings = settings
        self._publisher = publisher
        self._contents = contents
        self._today = today
        self._run: RecordingRun | None = None
        self._lock = threading.Lock()

    def start(self, parent: Path | None = None) -> Path:
        """Start a recording; return its folder, in ``parent`` or where the settings say.

        Raises:
            RecordingError: a recording already runs, or the folder cannot be made.
        """
        parent = parent or self.settings.path()
        with self._lock:
            if self._run is not None and self._run.running:
                raise RecordingError(f"{self._run.folder.name} is being recorded; stop it first")
            try:
                parent.mkdir(parents=True, exist_ok=True)
                folder = free_folder(parent, f"brickpose_{self._today():%Y_%m_%d-%H_%M_%S}")
            except (OSError, ValueError) as error:  # ValueError: a name with a NUL
                why = getattr(error, "strerror", error)
                raise RecordingError(
                    f"nothing can be recorded to {parent}: {why}; valid is a folder"
                ) from error
            self._run = RecordingRun(folder, self._publisher, self.settings, self._contents)
            return folder

    def stop(self) -> None:
        """End the recording, if there is one; its file is finished a moment later."""
        with self._lock:
            if self._run is not None:
                self._run.stop()

    def close(self) -> None:
        """End the recording, and wait until the file is finished."""
        self.stop()
        if self._run is not None:
            self._run.join()

    @property
    def folder(self) -> Path | None:
        """Folder of the last recording; None before the first."""
        return self._run.folder if self._run else None

    @property
    def failure(self) -> str | None:
        """Why the last recording ended by itself; None if it did not."""
        return self._run.failure if self._run else None

    @property
    def status(self) -> RecordingMessage | None:
        """The last recording, finished or not; None before the first."""
        run = self._run
        if run is None:
            return None
        return RecordingMessage(
            file=run.folder.name,
            running=run.running,
            duration_s=run.duration,
            size_bytes=run.size,
            message=run.failure or run.missing,
        )
