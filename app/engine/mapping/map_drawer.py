"""Draws the map of the floor while the robot drives, however it is driven.

The control loop only publishes its ticks, as it always does. A thread, which there is only while a
map is drawn, collects them, and a process of its own draws: in a thread, drawing would take
Python's lock from the control loop.
"""

from __future__ import annotations

import math
import re
import threading
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from app.engine.followed_drive import result_of, ticks_until
from app.engine.mailboxes.backlog import Backlog
from app.engine.mapping.map_files import write_map
from app.engine.mapping.mapped_drive import Drawn, MappedDrive
from app.engine.problems import LOG
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.worker_process import WorkerProcess
from robot.calibration.adjustment import CalibrationError
from robot.errors import BrickPoseError, CommandError
from robot.fields.field import FieldError
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.mapping.editing import without_stroke
from robot.mapping.pushed import push_remark
from robot.mapping.sketch import Sketch
from robot.mapping.tape_map import MappingError, TapeMap
from robot.worker_thread import WorkerThread

STEP_S = 0.5
"""After so much more of the drive its map is drawn again [s]."""
UNSEEN_S = 4.0
"""Without tape in sight for longer than this [s], the map depends on the wheels."""
MOST_WAITING = 3000
"""Most ticks that wait for the thread: a minute of them."""
PATIENCE_S = 3.0
STANDING_SD = np.array([0.003, 0.003, math.radians(0.5)])
"""How uncertain the pose in a new map is at least [m, m, rad]."""
DRIFT = np.array([0.05, 0.05, 0.10])
"""... and by how much more for each metre that was driven since [m, m, rad]."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")


@dataclass(frozen=True)
class Drawing:
    """The map that is drawn now, or the last one."""

    state: Literal["draw", "finish", "done", "failed"] = "draw"
    began: float | None = None
    """Stamp of the drive's first tick [s]; None before it."""
    seconds: float = 0.0
    """How long the drive is [s]."""
    version: int = 0
    """How often it was drawn."""
    sketch: Sketch | None = field(default=None, repr=False)
    """None before anything was drawn."""
    result: TapeMap | None = field(default=None, repr=False)
    """The whole map, when it is done."""
    map_from_odom: Pose2 | None = None
    """Where odometry began in the map."""
    words: str | None = None
    """What is wrong or missing, or why it failed."""


class MapDrawer:
    """Draws maps on command, and writes them; for any thread."""

    def __init__(self, program: Program) -> None:
        """Prepare for a program."""
        self._program = program
        self._drawing: Drawing | None = None
        self._finish = threading.Event()
        self._thread: WorkerThread | None = None
        self._lock = threading.Lock()

    @property
    def drawing(self) -> Drawing | None:
        """The map that is drawn now, or the last one; None without one."""
        return self._drawing

    def begin(self) -> None:
        """Draw a new map, from now on; the last one is forgotten.

        Raises:
            CommandError: one is drawn already.
        """
        with self._lock:
            if self._running:
                raise CommandError("a map is drawn already; finish or discard that one first")
            self._finish.clear()
            self._drawing = Drawing()
            subscribed = ExitStack()
            feed = subscribed.enter_context(self._program.engine.every.subscribe(MOST_WAITING))
            self._thread = WorkerThread(
                "map drawer",
                lambda stopping: self._run(subscribed, feed, stopping),
                owner="the map",
                patience=PATIENCE_S,
            )
            self._thread.start()

    def finish(self) -> None:
        """End the drive of the map, and adjust all of it.

        Raises:
            CommandError: no map is drawn, or nothing has been drawn yet.
        """
        drawing = self._drawing
        if not self._running or drawing is None or drawing.state != "draw":
            raise CommandError("no map is drawn now")
        if drawing.sketch is None:
            raise CommandError("nothing is drawn yet; drive on, with tape in sight")
        self._finish.set()

    def discard(self) -> None:
        """Forget the map, also while it is drawn.

        Raises:
            CommandError: there is none.
        """
        with self._lock:
            if self._drawing is None:
                raise CommandError("there is no map to discard")
            self.close()
            self._drawing = None

    def delete_stroke(self, number: int, version: int) -> None:
        """Delete a stroke from the finished map.

        Args:
            number: of the stroke, as ``/api/mapping`` of that version lists them.
            version: of the map.

        Raises:
            CommandError: there is no such stroke, or the map is another one by now.
        """
        with self._lock:
            drawn, drawing = self._done(), self._drawing
            assert drawing is not None  # it is done
            strokes = drawn.tidy.strokes
            if version != drawing.version:
                raise CommandError("the map has changed meanwhile; look again")
            if not 0 <= number < len(strokes):
                raise CommandError(f"there is no stroke {number}; valid is 0 to {len(strokes) - 1}")
            if len(strokes) == 1:
                raise CommandError("a map has a stroke at least; discard it instead")
            changed = replace(drawn, tidy=without_stroke(drawn.tidy, number))
            self._show(result=changed, version=version + 1)

    def save(self, name: str, folder: Path) -> Path:
        """Write the map to a folder, under a new name; return the drawing's file.

        Raises:
            CommandError: there is no map, or it cannot be written; it stays here.
        """
        drawn = self._done()
        if not NAME.fullmatch(name):
            raise CommandError(
                f"{name!r} is no name for a map; valid are 60 letters, digits, - and _"
            )
        path = folder / f"{name}.svg"
        if path.exists():
            raise CommandError(f"there is a map {name} already; choose another name")
        try:
            write_map(drawn, path, f"Drawn by driving: {name}")
        except (OSError, FieldError) as error:
            raise CommandError(f"the map cannot be written to {path}: {error}") from error
        return path

    def place(self, newest: Snapshot) -> Hypothesis:
        """Return where the robot is in the map that is done.

        Raises:
            CommandError: there is no such map.
        """
        drawn, drawing = self._done(), self._drawing
        assert drawing is not None and drawing.map_from_odom is not None  # it is done
        pose = drawing.map_from_odom @ newest.odom_from_robot
        last = drawing.map_from_odom.inverse() @ Pose2.from_array(drawn.solution.state.poses[-1])
        driven = newest.odom_from_robot.distance_to(last)
        sd = np.sqrt(np.diag(drawn.solution.pose_covariance))
        sd = np.maximum(sd, STANDING_SD) + driven * DRIFT
        return Hypothesis(1.0, pose, np.diag(sd**2))

    def close(self) -> None:
        """End the thread; may be called twice."""
        if self._thread is not None:
            self._thread.stop()

    @property
    def _running(self) -> bool:
        return self._thread is not None and self._thread.alive

    def _done(self) -> TapeMap:
        drawing = self._drawing
        if drawing is None or drawing.result is None:
            raise CommandError("there is no finished map")
        return drawing.result

    def _run(
        self, subscribed: ExitStack, feed: Backlog[Snapshot], stopping: threading.Event
    ) -> None:
        try:
            with WorkerProcess() as process:
                with subscribed:
                    drive = self._follow(feed, stopping, process)
                self._show(state="finish", words=None)
                drawn = result_of(drive.finish(), stopping)
                self._show(
                    state="done",
                    result=drawn,
                    map_from_odom=drive.map_from_odom(drawn),
                    words=None,
                    version=self._version + 1,
                )
        except BrickPoseError as error:
            self._show(state="failed", words=str(error))
        except Exception as error:
            LOG.exception("the map failed")
            self._show(state="failed", words=str(error))

    def _follow(
        self, feed: Backlog[Snapshot], stopping: threading.Event, process: WorkerProcess
    ) -> MappedDrive:
        """Collect the drive until it is to be finished, and let the process draw on the way."""
        drive: MappedDrive | None = None
        waiting: Future[Drawn] | None = None
        due = STEP_S
        for snapshot in ticks_until(self._finish, feed, stopping):
            if drive is None:
                if snapshot is not None:
                    drive = MappedDrive(self._program, snapshot, process)
                    self._show(began=drive.began)
                continue
            if snapshot is not None:
                drive.add(snapshot)
            if waiting is not None and waiting.done():
                self._keep(drive, result_or_words(waiting, stopping))
                waiting = None
            if waiting is None and due <= drive.seconds:
                waiting, due = drive.draw(), drive.seconds + STEP_S
                self._show(seconds=drive.seconds)
        assert drive is not None  # without a sketch, it is not finished
        if waiting is not None:
            self._keep(drive, result_or_words(waiting, stopping))
        return drive

    def _keep(self, drive: MappedDrive, drawn: Drawn | str) -> None:
        if isinstance(drawn, str):
            # More of the drive may show what is missing.
            self._show(words=drawn)
            return
        map_from_odom, sketch = drive.keep(drawn), drawn.sketch
        if sketch is None:
            return
        unseen = drive.began + drive.seconds - drive.seen
        words = None
        if sketch.moved_at is not None:
            words = push_remark(sketch.moved_at)
        elif unseen > UNSEEN_S:
            words = (
                f"no tape has been in sight for {unseen:.0f} s: meanwhile only the wheels tell "
                "where the robot is"
            )
        self._show(
            sketch=sketch, map_from_odom=map_from_odom, version=self._version + 1, words=words
        )

    @property
    def _version(self) -> int:
        return 0 if self._drawing is None else self._drawing.version

    def _show(self, **changes: Any) -> None:
        if self._drawing is not None:
            self._drawing = replace(self._drawing, **changes)


def result_or_words(job: Future[Drawn], stopping: threading.Event) -> Drawn | str:
    """Wait for what a job has drawn; if it could not draw yet, return why."""
    try:
        return result_of(job, stopping)
    except (MappingError, CalibrationError) as error:
        return str(error)
