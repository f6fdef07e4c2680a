"""Pilot: it sets the velocity of each tick while there is a journey."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from app.engine.controls import Controls
from app.features.navigation.choices import Choices
from app.features.navigation.journey import Journey, curve_of
from app.features.navigation.messages import (
    CancelCommand,
    SetWallsCommand,
    TakePlaceCommand,
)
from app.features.navigation.walls import NOTHING_SAID, walls_in
from app.features.own_models.error_messages import running
from app.languages.marking import phrase
from app.messages.commands import Command
from app.settings.config import Config
from robot.covariance import widest
from robot.driving.differential_drive import DifferentialDrive
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.geometry import Pose2, Twist2
from robot.interface import Reading
from robot.navigation.free_space import FreeSpace
from robot.navigation.line_follower import LineFollower
from robot.navigation.lookout import Move, OnlyPlace, look
from robot.navigation.navigation_status import NavigationStatus
from robot.navigation.navigator import Navigator, Plan
from robot.navigation.planners import PLANNERS
from robot.navigation.planning import NoWayError
from robot.navigation.possible_places import Glimpse
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits
from robot.navigation.walls import Walls

FIRST_PATIENCE_S = 0.1
"""A way is driven the planner's patience after its planning began [s], on the robot's clock, so
that drives repeat exactly, however fast the computer is. The first one is driven so much later, as
it also needs the free space. Where robot time is real time, nobody waits for a plan that takes
longer: the robot stands until it is there."""
HANGS_S = 10.0
"""A planner that is not ours is given up if it has not ended after so long [s]."""
LOOK_PATIENCE_S = 0.8
"""The same of a move by which the robot learns where it is."""
MOST_PLACES = 20
"""So many places that the filter believes in are thought of."""
LONGEST_TICK_S = 1.0
"""A longer time between two ticks is a jump of a replay."""


class Pilot:
    """Navigates in one engine; ways are planned in a thread."""

    referenced = True
    """A journey that a replay stores goes on with the same pilot."""

    def __init__(self, config: Config, field: Field, stamp: float, *, waits: bool = True) -> None:
        """Prepare at a stamp [s]; nothing is worked out before the first goal.

        ``waits`` for plans that are due; else they are taken as soon as they are there.
        """
        self._waits = waits
        self.settings: NavigationSettings = config.group("navigation", NavigationSettings())
        self.shown: NavigationStatus | None = None
        self._config = config
        self._field = field
        self._journey: Journey | None = None
        self._walls = NOTHING_SAID
        self._free: tuple[Walls, FreeSpace] | None = None
        self._marks: FreeSpace | None = None
        """Distances to what the robot sees, whether it is a wall or not."""
        self._future: Future[Plan] | None = None
        self._due = 0.0
        self._stamp = stamp
        self._choices = Choices(self.settings)
        self._kind = PLANNERS["grid"]
        self._hangs: float | None = None
        """What is planned is given up so long after it is due [s]; None is never."""
        self._tells = False
        """Whether recordings shall know the walls of a journey: it may be older than they."""
        self._canceled = False
        """Whether recordings shall know that a journey was ended by something else."""
        self._found: OnlyPlace | None = None
        """Where looking around has shown that the robot is, to be told to the filter."""

    @property
    def needs_pictures(self) -> bool:
        """Whether the camera must not rest."""
        return self._journey is not None

    def commands(self, controls: Controls) -> Iterable[Command]:
        """Tell the filter what was found out, and recordings how a journey ended, and its walls."""
        canceled, self._canceled = self._canceled, False
        tells, self._tells = self._tells, False
        place, self._found = self._found, None
        if place is not None:
            pose = place.pose
            yield TakePlaceCommand(
                type="take_place",
                x=pose.x,
                y=pose.y,
                theta=pose.theta,
                covariance=place.covariance.reshape(-1).tolist(),
            )
        if tells:
            zones = [list(zone) for zone in self._walls.zones]
            said = {"type": "set_walls", "tape": self._walls.tape, "zones": zones}
            yield SetWallsCommand.model_validate(said)
        if canceled:
            yield CancelCommand(type="cancel", before=controls.stamp)

    def add(self, reading: Reading, controls: Controls) -> None:
        """Set the velocity of this tick, if there is a journey."""
        programme = controls.driving.programme
        journey = programme if isinstance(programme, Journey) else None
        before, self._stamp = self._stamp, reading.stamp
        if not 0 <= reading.stamp - before <= LONGEST_TICK_S:
            self._jump(journey)
        if journey is not self._journey:
            self._change(journey, controls)
        if journey is None or journey.helm.navigator is None:
            return
        navigator = journey.helm.navigator
        tick = _tick(reading, controls)
        self._heed_walls(navigator, walls_in(controls.kept))
        if getattr(controls.follower, "paused", False) and journey.line is None:
            navigator.cancel(phrase("the filter was paused"))
        self._plan(navigator, tick, controls)
        if journey.helm.taken:
            journey.helm.set(navigator.step(tick))
        else:
            navigator.hold(tick)
            journey.helm.twist = Twist2()
        self._show(navigator.status, journey)
        if not navigator.status.active:
            self._journey = None
            controls.driving.stop()

    def close(self) -> None:
        """End the thread; a way that is planned is finished first."""
        if "_worker" in vars(self):
            self._worker.shutdown()

    @cached_property
    def _worker(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(1, "navigation")

    def _jump(self, journey: Journey | None) -> None:
        """Go on with the journey of another time, after a jump in a replay."""
        self._journey, self._future, self.shown = journey, None, None
        if journey is not None and journey.helm.navigator is not None:
            journey.helm.navigator.ask_again()

    def _change(self, journey: Journey | None, controls: Controls) -> None:
        """Begin a journey, or end one that something else has ended."""
        before, self._journey = self._journey, journey
        self._future = None
        if before is not None and before.helm.navigator is not None:
            before.helm.navigator.cancel(_why(before, journey, controls))
            self._show(before.helm.navigator.status, before)
            self._canceled = journey is None and not before.helm.canceled
        if journey is not None:
            self._walls = walls_in(controls.kept)
            self._tells = self._walls != NOTHING_SAID
            limits, curve = self._limits(controls.driving.kinematics), None
            if journey.line is not None:
                follower = LineFollower(journey.line.speed, limits, name=journey.name)
                journey.helm.navigator = follower
                self._show(follower.status, journey)
                return
            if journey.curve is not None:
                eight = self._config.figure_eight
                curve = curve_of(journey.curve, eight)
                limits = limits.along_curve(journey.curve.speed or eight.speed, self._config.drive)
            kind = self._choices.planner(journey.planner)
            self._kind = kind
            navigator = Navigator(
                journey.goals,
                self.settings,
                limits,
                look=partial(self._look, controls.spec.outline),
                name=journey.name,
                repeat=journey.repeat,
                curve=curve,
                planner=kind.plan,
                controller=self._choices.controller(journey.controller),
            )
            journey.helm.navigator = navigator
            self._show(navigator.status, journey)

    def _show(self, status: NavigationStatus, journey: Journey) -> None:
        """Show how far a journey is, and since when it is so."""
        before = self.shown
        same = before is not None and (before.began, before.state) == (journey.began, status.state)
        since = before.since if before is not None and same else self._stamp
        self.shown = replace(status, began=journey.began, since=since)

    def _limits(self, drive: DifferentialDrive) -> Limits:
        wheels = (drive.left, drive.right)
        rim = min(drive.spec.joints[each].max_velocity * drive.radii[each] for each in wheels)
        return Limits.of(self._config.drive, self.settings, float(rim), drive.track)

    def _heed_walls(self, navigator: Navigator | LineFollower, walls: Walls) -> None:
        """Stand, and plan anew, when somebody has said something else of walls."""
        if walls == self._walls:
            return
        self._walls = walls
        self._future = None
        navigator.ask_again()
        navigator.plan_anew()

    def _plan(self, navigator: Navigator | LineFollower, tick: Sensed, controls: Controls) -> None:
        """Have a way planned, or take one that is due."""
        if self._future is not None:
            if tick.stamp >= self._due and self._can_take(self._future, tick.stamp):
                future, self._future = self._future, None
                plan = self._result(future)
                navigator.take(plan)
                if isinstance(plan, Move) and navigator.looks:
                    self._found = plan.place
            return
        outline, walls = controls.spec.outline, self._walls
        job = navigator.job(lambda: self._space(outline, walls), tick)
        if job is not None:
            known = self._free is not None and self._free[0] == walls
            first = 0.0 if known else FIRST_PATIENCE_S
            ours = navigator.looks or self._kind.ends
            self._hangs = None if ours else HANGS_S
            patience = LOOK_PATIENCE_S if navigator.looks else self._kind.patience
            self._due = tick.stamp + patience + first
            self._future = self._worker.submit(job)

    def _can_take(self, future: Future[Plan], stamp: float) -> bool:
        """Whether what is due may be taken, without a tick that waits where none may."""
        late = self._hangs is not None and stamp >= self._due + self._hangs
        return self._waits or future.done() or late

    def _result(self, future: Future[Plan]) -> Plan | BrickPoseError:
        """Return a way that is due, or why there is none."""
        try:
            return future.result(self._hangs if self._waits else 0.0)
        except TimeoutError:
            stuck, self._worker = self._worker, ThreadPoolExecutor(1, "navigation")
            where = next((running(each.ident) for each in stuck._threads), None)
            stuck.shutdown(wait=False)
            return NoWayError(where or phrase("the planner does not end"))
        except BrickPoseError as error:
            return error

    def _look(
        self,
        outline: np.ndarray,
        views: tuple[Glimpse, ...],
        odom: Pose2,
        places: tuple[Pose2, ...],
        dares: int,
    ) -> Move:
        """Return the move that tells most of where the robot is; in the thread."""
        if self._marks is None:
            tape = Walls(tape="wall")
            self._marks = FreeSpace.of(self._field, outline, self.settings, tape, edge=False)
        free = self._space(outline, self._walls)
        crosses = self._walls.ignore_tape(self._field, self.settings)
        return look(views, odom, self._marks, free, places, dares=dares, crosses_tape=crosses)

    def _space(self, outline: np.ndarray, walls: Walls) -> FreeSpace:
        """Return the free space; in the thread."""
        if self._free is None or self._free[0] != walls:
            self._free = walls, FreeSpace.of(self._field, outline, self.settings, walls)
        return self._free[1]


def _why(before: Journey, journey: Journey | None, controls: Controls) -> str:
    """Return in words why a journey has ended."""
    if before.helm.canceled:
        return phrase("somebody canceled it")
    if journey is not None:
        return phrase("another goal took its place")
    if controls.driving.mode == "idle":
        return controls.driving.halted or phrase("the robot was stopped")
    return phrase("somebody drives the robot otherwise")


def _tick(reading: Reading, controls: Controls) -> Sensed:
    odometry, follower = controls.odometry.at(reading.stamp), controls.follower
    belief, newest = follower.belief, getattr(follower, "newest", None)
    pose: Pose2 | None = None
    places: tuple[Pose2, ...] = ()
    spread = 0.0
    if belief is not None:
        pose = belief.pose(odometry.odom_from_robot)
        spread = widest(belief.estimate.covariance)
        moved = belief.moved(odometry.odom_from_robot)
        places = tuple(each.pose @ moved for each in belief.estimate.hypotheses[:MOST_PLACES])
    return Sensed(
        reading.stamp,
        pose,
        odometry.twist,
        follower.integrity_at(odometry.odom_from_robot),
        odometry.odom_from_robot,
        None if newest is None else Glimpse(newest[1], newest[0]),
        places,
        spread,
    )
