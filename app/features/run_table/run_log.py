"""RunLog: the runs of a program, picture by picture, each with its filter's parameters."""

from __future__ import annotations

import math
import threading
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field, fields

import numpy as np

from app.engine.follower import FilterState
from app.engine.snapshot import Snapshot
from app.features.run_table.figures import FAR_M, FAR_RAD, RunSamples
from app.messages.commands import (
    PlaceCommand,
    ResetCommand,
    ScatterCommand,
    SetPoseCommand,
)
from robot.geometry import Pose2, wrap_angle
from robot.localization.estimate import State
from robot.localization.parameters import LocalizationParameters
from robot.settings import describe

MOST_RUNS = 20
"""Runs that are listed; older ones are forgotten, unless they are kept."""
MOST_PICTURES = 110_000
"""Pictures of one run: an hour of them."""
SHORTEST_S = 2.0
"""A run that was shorter [s] is not listed once another one has begun."""

JUMP_M, FASTEST = 0.05, 1.0
"""A robot that is farther [m] from where it was than it can have driven [m/s] was put there."""
TELLING = (SetPoseCommand, ScatterCommand, ResetCommand, PlaceCommand)
UNKNOWING = (State.AMBIGUOUS, State.SEARCHING, State.LOST)
"""While the filter says so, it has no single place for the robot's."""
Parameters = dict[str, object]
UNITS = {
    name: known.unit
    for group in fields(LocalizationParameters)
    for name, known in describe(getattr(LocalizationParameters(), group.name)).items()
}
"""Of the filter's parameters, by name."""


@dataclass(eq=False)
class ListedRun:
    """One run: with the same parameters, from a belief that was told on."""

    number: int
    """From 1 on, as they began."""
    file: str
    """Name of the recording that it replays; empty if the robot drove."""
    place: str
    """Name of the field."""
    parameters: Parameters
    """All of the filter's, by name, and the models of features."""
    recorded: bool = False
    """Whether its estimates are those that a recording has, and not computed now."""
    kept: bool = False
    _rows: array[float] = field(default_factory=lambda: array("d"), repr=False)

    def add(self, stamp: float, error: float, turn: float, misleading: bool) -> None:
        """Add a picture: its stamp [s], the estimate's errors [m, rad], and whether it misleads."""
        if len(self._rows) < 4 * MOST_PICTURES:
            self._rows.extend((stamp, error, turn, float(misleading)))

    @property
    def samples(self) -> RunSamples:
        """What is known of its pictures."""
        rows = np.array(self._rows).reshape(-1, 4)
        return RunSamples(rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3])

    @property
    def empty(self) -> bool:
        """Whether it has no picture yet."""
        return not self._rows

    @property
    def seconds(self) -> float:
        """How long it is [s]."""
        return self._rows[-4] - self._rows[0] if self._rows else 0.0


class RunLog:
    """The last runs, and those that are kept; for any thread.

    A run begins with the program, another field or recording, other parameters, a pose that is
    told, a scattered or reset cloud, a robot that is put elsewhere, and where a replay goes back.
    Pictures count while the robot drives, and until the estimate is right: a robot that stands
    would make its last error the run's.
    """

    def __init__(self, place: str, earlier: RunLog | None = None) -> None:
        """Begin on a field; ``earlier`` is the log of the program before, whose runs stay."""
        self._place = place
        self._lock = threading.Lock()
        self._runs: list[ListedRun] = [] if earlier is None else list(earlier)
        self._standard: Parameters | None = None if earlier is None else earlier.standard
        self._number = max((run.number for run in self._runs), default=0)
        self._now: ListedRun | None = None
        self._then: ListedRun | None = None
        self._seen = -math.inf
        self._updates = 0
        self._stamp = -math.inf
        self._truth: Pose2 | None = None
        self._held: tuple[object, object] = (None, None)
        self._named: Parameters = {}
        """The parameters in the last tick, and by their names."""

    @property
    def standard(self) -> Parameters | None:
        """The parameters at the start, which those of runs are compared with; None before."""
        return self._standard

    def __iter__(self) -> Iterator[ListedRun]:
        """Return the runs that are listed, the newest first."""
        with self._lock:
            return iter(list(self._runs))

    @property
    def present(self) -> tuple[ListedRun, ...]:
        """The runs that go on: the present one, and what the recording has of it."""
        return tuple(run for run in (self._now, self._then) if run is not None)

    def run(self, number: int) -> ListedRun | None:
        """Return a run by its number; None if there is no such run any more."""
        return next((run for run in self if run.number == number), None)

    def forget(self, run: ListedRun) -> None:
        """List a run no more; if it is the present one, another one begins."""
        with self._lock:
            self._runs = [each for each in self._runs if each is not run]
            if run is self._now:
                self._now = None
            if run is self._then:
                self._then = None

    def add(self, snapshot: Snapshot) -> None:
        """Take the newest picture of a tick, if it is new and the truth is known."""
        seen, truth, replay = snapshot.filter.line_scan, snapshot.truth, snapshot.replay
        if truth is None or seen is None or (replay and replay.catching_up is not None):
            return
        stamp = seen.scan.stamp
        with self._lock:
            self._begin(snapshot)
            if stamp <= self._seen:
                return
            self._seen = stamp
            stands = snapshot.twist.v == 0 and snapshot.twist.omega == 0
            assert self._now is not None  # just begun
            # Among places that look alike, the heaviest one is so by chance.
            pose = None if snapshot.integrity.state in UNKNOWING else snapshot.pose
            error, turn = _errors(pose, truth)
            right = error <= FAR_M and turn <= FAR_RAD
            if stands and replay is None and right and not self._now.empty:
                return
            integrity = snapshot.integrity
            outside = error > integrity.radius or turn > integrity.heading_bound
            certain = integrity.state is State.CERTAIN
            self._now.add(stamp, error, turn, certain and outside)
            if self._then is not None and replay is not None:
                self._then.add(stamp, *_errors(replay.estimate_then, truth), False)

    def _begin(self, snapshot: Snapshot) -> None:
        """Begin another run if this tick is of another one."""
        parameters, replay = self._parameters_of(snapshot.filter), snapshot.replay
        if self._standard is None:
            self._standard = parameters
        file = replay.file if replay else ""
        is_another = self._begins_anew(snapshot)
        present = self._now
        if present and not is_another and (present.parameters, present.file) == (parameters, file):
            return
        self._seen = -math.inf
        if present and present.seconds < SHORTEST_S and not present.kept:
            self._runs.remove(present)
        self._now = self._new(ListedRun(0, file, self._place, parameters))
        self._then = None
        if replay is not None and replay.estimate_then is not None:
            known = next((run for run in self._runs if run.recorded and run.file == file), None)
            if known is None:
                self._then = self._new(ListedRun(0, file, self._place, {}, recorded=True))

    def _parameters_of(self, state: FilterState) -> Parameters:
        """Return the parameters by their names; most ticks hold those of the tick before."""
        held = state.parameters, state.models
        if any(now is not then for now, then in zip(held, self._held, strict=True)):
            self._held, self._named = held, parameters_of(state)
        return self._named

    def _begins_anew(self, snapshot: Snapshot) -> bool:
        """Whether the belief was told, the robot put elsewhere, or a replay went back."""
        updates, stamp, truth = snapshot.filter.updates, snapshot.stamp, snapshot.truth
        # Pages are not told each tick: one with such a command may be missing.
        has_told = any(isinstance(command, TELLING) for command in snapshot.commands)
        is_another = has_told or updates < self._updates or stamp < self._stamp
        if truth is not None and self._truth is not None:
            way = truth.distance_to(self._truth)
            is_another |= way > JUMP_M + FASTEST * abs(stamp - self._stamp)
        self._updates, self._stamp, self._truth = updates, stamp, truth
        return is_another

    def _new(self, run: ListedRun) -> ListedRun:
        self._number += 1
        run.number = self._number
        self._runs.insert(0, run)
        spare = [each for each in self._runs if not each.kept][MOST_RUNS:]
        self._runs = [each for each in self._runs if each not in spare]
        return run


def parameters_of(state: FilterState) -> Parameters:
    """Return the filter's parameters by their names, and the models of features."""
    groups = (getattr(state.parameters, group.name) for group in fields(state.parameters))
    values: Parameters = {
        name: getattr(group, name) for group in groups for name in describe(group)
    }
    if state.models.sensor:
        values["laser_model_type"] = state.models.sensor
    if state.models.motion:
        values["robot_model_type"] = state.models.motion
    return values


def differences(parameters: Parameters, standard: Parameters) -> dict[str, object]:
    """Return the parameters that differ from others, by name."""
    return {name: value for name, value in parameters.items() if value != standard.get(name, value)}


def _errors(pose: Pose2 | None, truth: Pose2) -> tuple[float, float]:
    """Return distance [m] and difference of headings [rad]; inf without a pose."""
    if pose is None:
        return math.inf, math.inf
    return pose.distance_to(truth), abs(float(wrap_angle(pose.theta - truth.theta)))
