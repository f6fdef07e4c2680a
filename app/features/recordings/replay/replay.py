"""A running replay: pause, seek, step by picture, slower and faster.

It replaces the engine's own loop, in the engine's thread.
"""

from __future__ import annotations

import gc
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from app.engine.problems import LOG
from app.engine.snapshot import ReplayState, Snapshot
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.preview import Preview
from app.features.recordings.replay.requests import RequestMailbox
from app.features.recordings.replay.timeline import Timeline
from app.messages.commands import Command, ResetCommand, SetParametersCommand
from robot.interface import Frame
from robot.localization.filter import Cloud

STATUS_S = 0.1
"""Interval of status messages while paused or waiting [s]."""

PIECE_S = 0.03
"""How long a seek goes on between two checks for requests [s]."""

TOLD_S = 0.1
"""Interval of progress messages during a seek [s]."""

LONGEST_GAP_S = 2.0
"""Longest wait for a gap in the recording [s of the recording]."""

SHORT_S = 0.002
"""A remaining wait this short is ignored [s]."""

BEHIND_S = 0.1
"""A delay longer than this is not made up for [s]."""

LOADED = 500
"""Ticks after which all compiled code is loaded, as in the engine's own loop."""

NOTHING = Cloud(np.empty((0, 3)), np.empty(0))
"""The empty cloud, shown during a seek."""


@dataclass(slots=True)
class _Way:
    """A seek or a step that is under way."""

    from_ns: int
    to_ns: int | None
    """Time to seek to; None for a step, whose end depends on the pictures."""
    ticks: Iterator[Snapshot]
    preview: Snapshot | None
    """What was recorded at the target, to be shown meanwhile."""
    said: float = 0.0
    """When its progress was last shown, on the computer's monotonic clock [s]."""


class Replay:
    """Controls the pace; ``asked`` is for any thread, everything else for the engine's."""

    def __init__(
        self,
        timeline: Timeline,
        file: str,
        duration_s: float,
        *,
        paused: bool = False,
        speed: float = 1,
    ) -> None:
        self.timeline = timeline
        self.asked = RequestMailbox()
        self._file = file
        self.duration_s = duration_s
        """From the first to the last tick [s]."""
        self._paused = paused
        self._speed = speed
        self._way: _Way | None = None
        self._later: list[Command] = []
        """Commands for the filter at the end of the seek."""
        self._shown: Snapshot | None = None
        self._begun: Snapshot | None = None
        """The first tick, if it was run before the others."""
        self._ticks = 0
        self._zero: float | None = None
        """When the recording would have begun if it had been played at this speed without a stop,
        on the computer's monotonic clock [s]."""

    def begin(self) -> None:
        """Run the first tick already, before there is a thread: without one, nothing can be shown.

        Raises:
            RecordingError: it fails; the recording is closed then.
        """
        try:
            self._begun = self._tick()
        except Exception as error:
            LOG.exception("the replay did not begin")
            self.timeline.robot.close()
            raise RecordingError(f"{self._file} cannot be replayed: {error}") from error

    def run(self, stop: threading.Event) -> None:
        """Replay until ``stop`` is set; the recording is closed whatever happens."""
        engine = self.timeline.engine
        try:
            self._show(self._begun or self._tick())
            while not stop.is_set():
                self._take_requests()
                if self._way is not None:
                    self._continue_seek(self._way)
                elif self._paused:
                    self._stand()
                else:
                    self._play()
        except Exception as error:
            LOG.exception("the replay stopped")
            engine.fail(f"The replay stopped: {error}")
        finally:
            engine.controls.robot.close()

    def _take_requests(self) -> None:
        requests = self.asked.take()
        over = self.timeline.robot.next_ns is None
        if requests.speed is not None:
            self._speed, self._zero = requests.speed, None
        if requests.paused is not None:
            self._paused, self._zero = requests.paused, None
            if over and not requests.paused and requests.position_s is None and self._way is None:
                requests.position_s = 0.0
        if requests.position_s is not None:
            self._go_to(self._start_ns + round(1e9 * requests.position_s))
        if requests.steps and self._way is not None:
            self.asked.ask(step=requests.steps)  # after the seek
        elif requests.steps:
            self._paused = True
            self._step(requests.steps)

    @property
    def _start_ns(self) -> int:
        return self.timeline.robot.start_ns

    def _play(self) -> None:
        """Wait until the next tick is due, and run it; end early after a request or a status."""
        following = self.timeline.robot.next_ns
        if following is None:
            self._paused = True
            return
        clock = time.monotonic()
        last_s, next_s = ((t - self._start_ns) / 1e9 for t in (self.timeline.log_ns, following))
        if self._zero is None or next_s - last_s > LONGEST_GAP_S:
            self._zero = clock - last_s / self._speed
            if next_s - last_s > LONGEST_GAP_S:
                self._zero -= (next_s - last_s - LONGEST_GAP_S) / self._speed
        due = self._zero + next_s / self._speed
        if due > clock and self.asked.wait(min(due - clock, STATUS_S)):
            return
        if due > time.monotonic() + SHORT_S:
            self._show(self.timeline.apply_between_ticks(self.timeline.engine.commands.take()))
            return
        if clock - due > BEHIND_S:
            self._zero += clock - due
        self._show(self._tick(self.timeline.engine.commands.take()))

    def _stand(self) -> None:
        """Show that the replay is paused, and carry out commands."""
        self._show(self.timeline.apply_between_ticks(self.timeline.engine.commands.take()))
        self.asked.wait(STATUS_S)

    def _step(self, pictures: int) -> None:
        """Step forward by a number of pictures, or back if it is negative."""
        if pictures < 0:
            self._go_to(self.timeline.picture_before(-pictures))
        else:
            enabled = self.timeline.ticks_with_pictures(pictures)
            self._way = _Way(self.timeline.log_ns, None, enabled, None, time.monotonic())

    def _go_to(self, log_ns: int) -> None:
        """Start to seek to a time; a time before the first tick becomes that of the first tick."""
        log_ns = max(log_ns, self._start_ns)
        target = self.timeline.go_near(log_ns)
        self._zero = None
        self._later = []
        self._way = _Way(
            max(self.timeline.log_ns, self._start_ns),
            log_ns,
            self.timeline.ticks_up_to(log_ns),
            self._preview_snapshot(target),
            time.monotonic(),
        )

    def _continue_seek(self, way: _Way) -> None:
        """Continue a seek or a step for ``PIECE_S``, as fast as possible."""
        until = time.monotonic() + PIECE_S
        while time.monotonic() < until:
            snapshot = next(way.ticks, None)
            if snapshot is None:
                self._arrive()
                return
            self._shown = snapshot
            self._count()
        if not self._change_on_the_way(way) and until - way.said > TOLD_S and self._shown:
            way.said = until
            self._show(replace(way.preview or self._shown, published=time.monotonic()))

    def _arrive(self) -> None:
        self._way = None
        commands, self._later = tuple(self._later), []
        self._show(self.timeline.apply_between_ticks(commands))

    def _change_on_the_way(self, way: _Way) -> bool:
        """Take commands during a seek; return whether it starts again because of new settings."""
        given = self.timeline.engine.commands.take()
        if way.to_ns is None:
            self._later += given
            return False
        changes = [each for each in given if isinstance(each, (ResetCommand, SetParametersCommand))]
        self._later += [item for item in given if item not in changes]
        for change in changes:
            assert isinstance(change, SetParametersCommand | ResetCommand)
            self.timeline.change(change)
        if self.timeline.pure and not changes:
            return False
        later = self._later
        self._go_to(way.to_ns)
        self._later = later
        return True

    def _tick(self, commands: tuple[Command, ...] = ()) -> Snapshot:
        snapshot = self.timeline.tick(commands)
        self._count()
        return snapshot

    def _count(self) -> None:
        self._ticks += 1
        if self._ticks == LOADED:
            gc.freeze()

    def _show(self, snapshot: Snapshot) -> None:
        """Publish a snapshot, with the state of the replay."""
        self._shown = snapshot
        self.timeline.engine.publish(replace(snapshot, replay=self._state(snapshot)))

    def _state(self, snapshot: Snapshot) -> ReplayState:
        way, progress = self._way, None
        earlier = self.timeline.estimate_then(snapshot)
        log_ns = self.timeline.log_ns
        if way is not None and way.to_ns is not None:
            progress = (log_ns - way.from_ns) / max(way.to_ns - way.from_ns, 1)
            log_ns, earlier = way.to_ns, snapshot.scan_pose
        return ReplayState(
            self._file,
            min((log_ns - self._start_ns) / 1e9, self.duration_s),
            self.duration_s,
            self._speed,
            self._paused,
            None if progress is None else min(max(progress, 0.0), 1.0),
            earlier,
        )

    def _preview_snapshot(self, preview: Preview | None) -> Snapshot | None:
        """The last snapshot, with the recorded picture, scan and estimate of another time."""
        last = self._shown
        if preview is None or last is None:
            return None
        scanner = self.timeline.engine.localization.scanner
        # The stamp as if no stamp had jumped; it is only shown during the seek.
        stamp = (preview.log_ns - self._start_ns) / 1e9
        frame = preview.frame and Frame(stamp, preview.frame.image)
        return replace(
            last,
            stamp=stamp,
            frame=frame,
            scan_pose=preview.recorded_estimate,
            truth=preview.truth,
            pose=None,
            estimate=None,
            filter=replace(
                last.filter, line_scan=scanner.scan(frame) if frame else None, cloud=NOTHING
            ),
        )
