"""Draws the map of the floor while the robot drives, however it is driven.

The control loop only publishes its ticks, as it always does. A thread, which there is only while a
map is drawn, collects them, and a process of its own draws.
"""

from __future__ import annotations

import math
import re
import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

import numpy as np

from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.drive_follower import DriveFollower
from app.features.mapping.drawing import MapDrawing, ShownDrawing
from app.features.mapping.drawing_work import DrawingWork
from app.features.mapping.exploration import Exploration
from app.features.mapping.map_files import write_map
from app.features.mapping.messages import NoMapError
from app.result_files import is_portable
from robot.errors import BrickPoseError, CommandError
from robot.estimation.fit_quality import ContradictionError
from robot.fields.field import FieldError
from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.mapping.editing import with_joined, with_moved_end, without_stroke
from robot.mapping.tape_map import TapeMap
from robot.mapping.tidying import TidyStrokes

MOST_WAITING = 3000
"""Most ticks that wait for the thread: a minute of them."""
ANSWER_S = 20.0
"""Longest wait for the map so far, while it is drawn [s]."""
STANDING_SD = np.array([0.003, 0.003, math.radians(0.5)])
"""Least uncertainty of the pose in a new map [m, m, rad]."""
DRIFT = np.array([0.05, 0.05, 0.10])
"""... and by how much more for each metre that was driven since [m, m, rad]."""
FARTHEST_END = 2.0
"""Tape has an end at most so far from where the robot was [m]: the camera sees half of that."""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")


class MapDrawer:
    """Draws maps on command, and writes them; for any thread.

    All but ``finish``, ``pause`` and the properties may take a part of a second, or more.
    """

    def __init__(self, program: Program) -> None:
        """Prepare for a program."""
        self._program = program
        self._side = program.config.ros2.map_resolution
        self._shown = shown = ShownDrawing(program.engine)
        self._work = DrawingWork(program, shown)
        self._follower = DriveFollower(
            program,
            "map",
            MOST_WAITING,
            self._work.draw,
            lambda words: shown.change(state="failed", words=words),
        )
        self._lock = threading.Lock()
        """One command at a time."""

    @property
    def drawing(self) -> MapDrawing | None:
        """The map that is drawn now, or the last one; None without one."""
        return self._shown.now

    def begin(self, *, discard: bool = False, paused: bool = False) -> None:
        """Draw a new map, from now on; the last one is forgotten.

        Args:
            discard: whether one that is drawn now is forgotten, too.
            paused: whether it begins with a pause.

        Raises:
            CommandError: one is drawn already, or is finished and not saved.
        """
        with self._lock:
            if not discard:
                self.require_none_lost()
            self.close()
            self._work.finish.clear()
            self._work.asked.take()
            self._work.exploration = None
            self._shown.begin(MapDrawing(paused=paused))
            self._follower.begin()

    def explore(self) -> None:
        """Give routes to a robot that explores from now on; without a map, begin one.

        Raises:
            CommandError: the last map is finished and not saved.
        """
        if not self._follower.running:
            self.begin()
        self._work.exploration = Exploration(self._program)

    def pause(self, paused: bool | None = None) -> None:
        """Stop adding pictures to the map, or add them again; None toggles.

        The wheels tell the robot's way meanwhile.

        Raises:
            NoMapError: no map is drawn.
        """
        drawing = self._required()
        self._shown.change(paused=not drawing.paused if paused is None else paused)

    def finish(self) -> None:
        """End the drive of the map, and adjust all of it.

        Raises:
            CommandError: no map is drawn, or nothing has been drawn yet.
        """
        self._required_sketch()
        self._work.finish.set()

    def discard(self) -> None:
        """Forget the map, also while it is drawn.

        Raises:
            NoMapError: there is none.
        """
        with self._lock:
            if self.drawing is None:
                raise NoMapError("there is no map to discard")
            self.close()
            self._shown.begin(None)

    def require_done(self) -> None:
        """Refuse what needs a finished map.

        Raises:
            NoMapError: there is none.
        """
        self._done()

    def require_none_lost(self) -> None:
        """Refuse what would lose a map.

        Raises:
            CommandError: one is drawn, or is finished and not saved.
        """
        drawing = self.drawing
        if drawing is not None and drawing.would_be_lost:
            if drawing.state == "done":
                raise CommandError("a map is finished; save or discard it first")
            raise CommandError("a map is drawn; finish or discard it first")

    def delete_stroke(self, number: int, version: int) -> None:
        """Delete a stroke from the finished map.

        Args:
            number: of the stroke, as ``/api/mapping`` of that version lists them.
            version: of the map.

        Raises:
            CommandError: there is no such stroke, or the map is another one by now.
        """
        self._edit(version, (number,), lambda tidy: without_stroke(tidy, number))

    def move_end(self, number: int, last: bool, place: tuple[float, float], version: int) -> None:
        """Move the first or last end of a stroke of the finished map to a place [m].

        Raises:
            CommandError: there is no such end, the map is another one by now, or the place is
                where the robot cannot have seen tape.
        """
        point = np.array(place)
        path = self._done().solution.state.poses[:, :2]
        away = float(np.linalg.norm(path - point, axis=1).min())
        if away > FARTHEST_END:
            raise CommandError(
                f"that is {away:.1f} m from where the robot was; valid is up to {FARTHEST_END:g} m"
            )
        self._edit(version, (number,), lambda tidy: with_moved_end(tidy, (number, last), point))

    def join_strokes(self, number: int, other: int, version: int) -> None:
        """Join two strokes of the finished map where their ends are nearest.

        Raises:
            CommandError: there are no such strokes, or the map is another one by now.
        """
        self._edit(version, (number, other), lambda tidy: with_joined(tidy, number, other))

    def _edit(
        self,
        version: int,
        numbers: tuple[int, ...],
        change: Callable[[TidyStrokes], TidyStrokes],
    ) -> None:
        """Change the strokes of the finished map; the numbers have to be valid."""
        with self._lock:
            drawn, drawing = self._done(), self.drawing
            assert drawing is not None  # it is done
            strokes = drawn.tidy.strokes
            if version != drawing.version:
                raise CommandError("the map has changed meanwhile; look again")
            for number in numbers:
                if not 0 <= number < len(strokes):
                    raise CommandError(
                        f"there is no stroke {number}; valid is 0 to {len(strokes) - 1}"
                    )
            try:
                changed = drawn.edited(change(drawn.tidy))
            except ValueError as error:
                raise CommandError(str(error)) from error
            self._show(changed, (*drawing.earlier, drawn))

    def undo_edit(self, version: int) -> None:
        """Take back the last change of the finished map.

        Raises:
            CommandError: nothing was changed, or the map is another one by now.
        """
        with self._lock:
            self._done()
            drawing = self.drawing
            assert drawing is not None  # it is done
            if version != drawing.version:
                raise CommandError("the map has changed meanwhile; look again")
            if not drawing.earlier:
                raise CommandError("nothing of the map was changed; there is nothing to take back")
            self._show(drawing.earlier[-1], drawing.earlier[:-1])

    def _show(self, result: TapeMap, earlier: tuple[TapeMap, ...]) -> None:
        """Show the finished map as it is after a change, and what it was before each."""
        drawing = self.drawing
        assert drawing is not None  # it is done
        self._shown.change(
            result.cells(self._side),
            result=result,
            earlier=earlier,
            version=drawing.version + 1,
            saved=False,
        )

    def save(self, name: str, folder: Path, *, force: bool = False) -> Path:
        """Write the map to a folder, under a new name; return the drawing's file.

        While it is drawn, the whole drive so far is adjusted first, and drawing continues.

        Raises:
            CommandError: there is no map, it contradicts itself (and is not forced), or it cannot
                be written; it stays here.
        """
        if not NAME.fullmatch(name):
            raise CommandError(
                f"{name!r} is no name for a map; valid are 60 letters, digits, - and _"
            )
        if not is_portable(name):
            raise CommandError(f"Windows takes no file of the name {name}; choose another name")
        path = folder / f"{name}.svg"
        if path.exists():
            raise CommandError(f"there is a map {name} already; choose another name")
        drawing = self.drawing
        drawn = self._so_far() if drawing and drawing.state == "draw" else self._done()
        try:
            drawn.quality.require_consistent(force=force)
        except ContradictionError as error:
            raise CommandError(str(error)) from error
        with self._lock:
            if path.exists():
                raise CommandError(f"there is a map {name} already; choose another name")
            try:
                write_map(drawn, path, f"Drawn by driving: {name}")
            except (OSError, FieldError) as error:
                raise CommandError(f"the map cannot be written to {path}: {error}") from error
            if drawn is self._result:
                self._shown.change(saved=True)
        return path

    def place(self, newest: Snapshot) -> Hypothesis:
        """Return where the robot is in the map that is done.

        Raises:
            CommandError: there is no such map.
        """
        drawn, drawing = self._done(), self.drawing
        assert drawing is not None and drawing.map_from_odom is not None  # it is done
        pose = drawing.map_from_odom @ newest.odom_from_robot
        last = drawing.map_from_odom.inverse() @ Pose2.from_array(drawn.solution.state.poses[-1])
        driven = newest.odom_from_robot.distance_to(last)
        sd = np.sqrt(np.diag(drawn.solution.pose_covariance))
        sd = np.maximum(sd, STANDING_SD) + driven * DRIFT
        return Hypothesis(1.0, pose, np.diag(sd**2))

    def close(self) -> None:
        """End the thread; may be called twice."""
        self._follower.close()

    def _required(self) -> MapDrawing:
        drawing = self.drawing
        if not self._follower.running or drawing is None or drawing.state != "draw":
            raise NoMapError("no map is drawn now")
        return drawing

    def _required_sketch(self) -> None:
        if self._required().sketch is None:
            raise NoMapError("nothing is drawn yet; drive on, with tape in sight")

    @property
    def _result(self) -> TapeMap | None:
        return self.drawing.result if self.drawing is not None else None

    def _done(self) -> TapeMap:
        result = self._result
        if result is None:
            raise NoMapError("there is no finished map")
        return result

    def _so_far(self) -> TapeMap:
        """Return the map of the drive so far, while it is drawn."""
        self._required_sketch()
        wanted: Future[TapeMap] = Future()
        self._work.asked.put(wanted)
        try:
            return wanted.result(ANSWER_S)
        except TimeoutError:
            raise CommandError(f"the map was not drawn within {ANSWER_S:g} s") from None
        except BrickPoseError as error:
            raise CommandError(str(error)) from error
