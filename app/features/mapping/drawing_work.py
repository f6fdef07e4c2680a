"""The work of a map drawer's thread: it collects the drive, and lets a process draw."""

from __future__ import annotations

import threading
from concurrent.futures import BrokenExecutor, Future
from functools import partial

from app.engine.mailboxes.backlog import Backlog
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.features.calibration.drive_follower import FollowedTicks
from app.features.calibration.followed_drive import FollowingError, result_of, ticks_until
from app.features.mapping.drawing import ShownDrawing
from app.features.mapping.exploration import Exploration
from app.features.mapping.mapped_drive import Drawn, MappedDrive, Whole
from robot.calibration.adjustment import CalibrationError
from robot.geometry import Pose2
from robot.mapping.exploring import RING
from robot.mapping.pushed import push_remark
from robot.mapping.tape_map import MappingError, TapeMap, near

STEP_S = 0.5
"""The map is drawn again after this much more of the drive [s]."""
UNSEEN_S = 4.0
"""If no tape is in sight for longer than this [s], the map depends on the wheels."""
EXPLORED = (
    f"the floor between the tape was seen, and around it for {RING[1]:.2g} m: finish the map, or "
    "drive to tape that is farther off"
)
NOTHING_SEEN = "no tape is in sight from here: drive to where the robot sees some"
MOST_ASKED = 10
"""Most requests that may wait for the map of the drive so far."""


class DrawingWork:
    """Draws one map after the other; other threads ask it to finish, or for the map so far."""

    def __init__(self, program: Program, shown: ShownDrawing) -> None:
        """Prepare to draw for a program, and to show what is drawn."""
        self._program = program
        self._shown = shown
        self.finish = threading.Event()
        """Set to end the drive."""
        self.asked = Backlog[Future[TapeMap]](MOST_ASKED)
        """Receives the map of the drive so far, while it is drawn."""
        self.exploration: Exploration | None = None
        """Gives routes to the robot; None if the robot does not explore."""

    def draw(self, ticks: FollowedTicks) -> None:
        """Draw a map tick by tick, until ``finish`` is set; then adjust the whole drive.

        Raises:
            MappingError, CalibrationError: the drive does not show enough of the floor.
            FollowingError: the thread must end.
        """
        try:
            with ticks.subscription:
                drive = self._follow(ticks)
            self._shown.change(state="finish", words=None, paused=False)
            job = drive.whole()
            self._answer(job)
            whole = result_of(job, ticks.stopping)
        finally:
            self._answer(_given_up())
        drawn = whole.drawn
        last = Pose2.from_array(drawn.solution.state.poses[-1])
        map_from_odom = drive.map_from_odom(last, float(drawn.stamps[-1]))
        version = self._version + 1
        self._shown.change(
            whole.grid, state="done", result=drawn, map_from_odom=map_from_odom, version=version
        )

    def _follow(self, ticks: FollowedTicks) -> MappedDrive:
        """Collect the drive until ``finish`` is set, and let the process draw meanwhile."""
        drive: MappedDrive | None = None
        waiting: Future[Drawn | None] | None = None
        due = STEP_S
        for snapshot in ticks_until(self.finish, ticks.feed, ticks.stopping):
            if snapshot is not None:
                if drive is None:
                    drive = MappedDrive(self._program, snapshot, ticks.process)
                    self._shown.change(began=drive.began)
                drive.add(snapshot, look=not self._paused)
                self._explore(snapshot)
            if drive is None:
                continue
            if len(self.asked):
                self._answer(drive.whole())
            if waiting is not None and waiting.done():
                self._keep(drive, waiting)
                waiting = None
            if waiting is None and due <= drive.seconds:
                waiting, due = drive.draw(), drive.seconds + STEP_S
                self._shown.change(seconds=drive.seconds)
        assert drive is not None  # without a sketch, it is not finished
        return drive

    def _explore(self, snapshot: Snapshot) -> None:
        drawing, exploration = self._shown.now, self.exploration
        if exploration is not None and drawing is not None:
            exploration.follow(snapshot, drawing.sketch, drawing.map_from_odom, drawing.cells)

    def _answer(self, job: Future[Whole]) -> None:
        """Pass a finished map on to those who asked for it."""
        for wanted in self.asked.take():
            job.add_done_callback(partial(_pass_on, wanted))

    def _keep(self, drive: MappedDrive, job: Future[Drawn | None]) -> None:
        try:
            drawn = job.result()
        except (MappingError, CalibrationError) as error:
            # The rest of the drive may show what is missing.
            self._shown.change(words=self._end_of_exploring or str(error))
            return
        if drawn is not None:
            sketch = drawn.sketch
            self._shown.change(
                drawn.grid,
                sketch=sketch,
                cells=drawn.grid,
                map_from_odom=drive.map_from_odom(sketch.pose, sketch.stamp),
                version=self._version + 1,
            )
        self._shown.change(words=self._remark(drive))

    def _remark(self, drive: MappedDrive) -> str | None:
        """Return what is wrong with the current map; None if nothing is wrong."""
        # What a push has done to the map is told again when it is finished.
        if self._end_of_exploring is not None:
            return self._end_of_exploring
        sketch = None if self._shown.now is None else self._shown.now.sketch
        if sketch is not None and sketch.moved_at is not None:
            return push_remark(sketch.moved_at, is_noise=True)
        unseen = drive.began + drive.seconds - drive.seen
        if unseen <= UNSEEN_S:
            return None
        return (
            f"no tape has been in sight for {unseen:.0f} s: meanwhile only the wheels tell where "
            "the robot is"
        )

    @property
    def _end_of_exploring(self) -> str | None:
        """Why the robot stopped exploring; None while it explores, or if it did not."""
        drawing, exploration = self._shown.now, self.exploration
        if exploration is None or not exploration.done or drawing is None:
            return None
        if drawing.sketch is None:
            return NOTHING_SEEN
        if len(exploration.unseen):
            return (
                f"the map is not whole: floor{near(exploration.unseen)} was not seen; drive there, "
                "or finish the map without it"
            )
        return EXPLORED

    @property
    def _paused(self) -> bool:
        return self._shown.now is not None and self._shown.now.paused

    @property
    def _version(self) -> int:
        return 0 if self._shown.now is None else self._shown.now.version


def _pass_on(wanted: Future[TapeMap], job: Future[Whole]) -> None:
    error = _discarded() if job.cancelled() else job.exception()
    if isinstance(error, BrokenExecutor):
        # Somebody ended the process while it worked.
        error = _discarded()
    if error is None:
        wanted.set_result(job.result().drawn)
    else:
        wanted.set_exception(error)


def _given_up() -> Future[Whole]:
    given_up: Future[Whole] = Future()
    given_up.set_exception(_discarded())
    return given_up


def _discarded() -> FollowingError:
    return FollowingError("the map was discarded")
