"""Recordings: starts and ends them, one at a time, each with a thread that writes it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from app.engine.mailboxes.backlog import Backlog
from app.engine.problems import LOG
from app.features.recordings.attachments import Contents
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.recording_file import RecordingFile, free_folder
from app.features.recordings.files.reserved_stream import FULL
from app.features.recordings.full_disk import FullDisk
from app.features.recordings.periods import recorded_every
from app.features.ros.message_types import MessageError
from app.features.ros.publisher import Pace, TopicPublisher, TopicRoute
from app.features.ros.topics import Published, Topic
from app.messages.telemetry import RecordingMessage
from app.settings.groups import RecordingSettings
from robot.worker_thread import WorkerThread

MOST_WAITING = 2000
"""Most messages that wait while the disk does not answer: about ten seconds of them."""

PERIOD_S = 0.15
"""Interval of writing [s]: writing each message on its own would cost a change of threads."""

JOIN_S = 5.0


class RecordingRun(TopicRoute):
    """A recording from its start to the finished file, with which its thread ends."""

    name = "recording"
    patience = PERIOD_S
    """Without other routes, several ticks may come at a time."""

    def __init__(
        self,
        folder: Path,
        publisher: TopicPublisher,
        settings: RecordingSettings,
        contents: Callable[[], Contents],
    ) -> None:
        """Begin to record into a new folder."""
        self.folder = folder
        self.failure: str | None = None
        """Why it ended by itself; None if it did not."""
        self.full_disk: FullDisk | None = None
        """The disk that was full, so that it ended; None if it did not."""
        self.duration = 0.0
        self.size = 0
        self._publisher = publisher
        self._contents = contents
        self._pace = Pace(lambda topic: recorded_every(topic, settings))
        self._waiting = Backlog[Published](MOST_WAITING)
        self._ticks_lost_before = publisher.lost
        self._unfit: dict[str, str] = {}
        self._thread = WorkerThread(
            "recording", self._run, owner="the recording", patience=JOIN_S, report=self._end
        )
        publisher.source.clock.hold()
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the file is not finished yet."""
        return self._thread.alive

    @property
    def missing(self) -> str | None:
        """What is missing in the recording, in words; None if nothing is."""
        parts = [f"{name} is not recorded: {why}." for name, why in dict(self._unfit).items()]
        ticks = max(0, self._publisher.lost - self._ticks_lost_before)
        messages = self._waiting.lost
        if messages or ticks:
            parts.append(
                f"{messages} messages and {ticks} ticks are missing: the disk or the computer "
                "is too slow."
            )
        return " ".join(parts) or None

    def wants(self, topic: Topic, stamp: float) -> bool:
        """Whether the topic is due at its rate; all that fit into recordings are recorded."""
        fit = topic.name not in self._unfit and not topic.only_dds
        return fit and self._pace.due(topic, stamp)

    def take(self, published: Published) -> None:
        """Leave a message for the thread; if there is no room, it is lost and counted."""
        self._waiting.put(published)

    def stop(self) -> None:
        """Ask the recording to finish; from any thread."""
        self._thread.stopping.set()

    def join(self) -> None:
        """Wait until the file is finished."""
        self._thread.join()

    def _run(self, stopping: threading.Event) -> None:
        try:
            self._record(stopping)
        finally:
            self._publisher.remove(self)
            self._publisher.source.clock.release()

    def _record(self, stopping: threading.Event) -> None:
        contents = self._contents()
        file = RecordingFile(self.folder, contents.facts)
        try:
            for attachment in contents.attachments:
                file.attach(attachment.name, attachment.data, attachment.media_type)
            self._publisher.add(self)
            while not stopping.wait(PERIOD_S):
                self._write_waiting(file)
            self._publisher.remove(self)
            self._write_waiting(file)
            if self.missing:
                file.note("missing", {"messages": self.missing})
            file.close()
        except BaseException:
            file.abandon()
            raise
        finally:
            self.size, self.duration = file.size, file.duration

    def _write_waiting(self, file: RecordingFile) -> None:
        if not self._waiting:
            file.flush()  # the robot has stopped answering: the last messages may matter most
        while (published := self._waiting.get()) is not None:
            self._write(file, published)
        self.size, self.duration = file.size, file.duration

    def _write(self, file: RecordingFile, published: Published) -> None:
        topic = published.topic
        try:
            cdr = published.cdr
        except MessageError as error:
            LOG.warning("%s is not recorded: %s", topic.name, error)
            self._unfit[topic.name] = str(error)
            return
        file.write(
            f"/{topic.name}",
            topic.type,
            topic.quality,
            published.log_time_ns,
            published.time_ns,
            cdr,
        )

    def _end(self, error: Exception) -> None:
        why = str(error)
        if isinstance(error, OSError):
            why = error.strerror or why
        else:
            LOG.exception("the recording failed")
        full = isinstance(error, OSError) and error.errno in FULL
        reason = "The disk is full" if full else f"The recording cannot be written ({why})"
        kept = "; it is kept" if self.folder.exists() else ""
        self.failure = f"{reason}: the recording ended after {self.duration:.0f} s{kept}."
        self.full_disk = FullDisk(self.folder.parent, self.failure) if full else None
        LOG.warning(self.failure)


class Recorder:
    """Makes one recording at a time; for any thread."""

    def __init__(
        self,
        publisher: TopicPublisher,
        settings: RecordingSettings,
        contents: Callable[[], Contents],
        today: Callable[[], datetime],
        full_disk: FullDisk | None = None,
    ) -> None:
        """Prepare to record; nothing is recorded before ``start``.

        Args:
            settings: where recordings go, and how much is in them.
            contents: returns the facts and files for the beginning of each recording; called in
                the recording's own thread.
            today: returns the date and time of the wall clock, for the names of recordings.
            full_disk: what the recorder of the program before this one found.
        """
        self.settings = settings
        self._publisher = publisher
        self._contents = contents
        self._today = today
        self._full_before = full_disk
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
    def full_disk(self) -> FullDisk | None:
        """The disk that was full at the last recording; None if none was."""
        return self._full_before if self._run is None else self._run.full_disk

    @property
    def problem(self) -> str | None:
        """That the disk is full, as long as it is; other failures end with their recording."""
        full = self.full_disk
        return None if full is None else full.problem

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
