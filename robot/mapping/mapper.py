"""Draws the tape of a floor while the robot drives on it (SLAM).

The drive is adjusted in windows that grow, as for a calibration, but the tape is not known. In each
window, new pictures are laid on the strokes that are known so far; all middles of tape are traced
anew; and path, robot and strokes are adjusted together. So a stretch of tape that is met again
closes the loop, and the whole path is corrected.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import (
    CalibrationError,
    DriveEstimate,
    Solution,
    Weights,
    quality_of,
)
from robot.calibration.calibrate import not_learnt
from robot.calibration.drive_log import DriveLog
from robot.calibration.misses import misses
from robot.calibration.sightings import Sightings
from robot.calibration.tracking import LEAST_GATE, laid, predicted
from robot.calibration.wheel_motion import WheelMotion
from robot.description.spec import RobotSpec
from robot.description.unknowns import (
    COUNT,
    LEFT,
    PRIORS,
    RIGHT,
    SEPARATION,
    TAPE,
)
from robot.estimation.fit_quality import FitQuality
from robot.geometry import Array, Pose2
from robot.mapping.bends import at_corners, cut_at_corners
from robot.mapping.crossings import BareFloor, is_tape
from robot.mapping.cutting import without_gaps
from robot.mapping.ends import RaysOnFloor
from robot.mapping.joining import joined
from robot.mapping.lengthwise import find_lengthwise
from robot.mapping.map_adjustment import MapAdjustment, moved_to_start
from robot.mapping.moving import moving
from robot.mapping.passing import (
    DEFERRED,
    PASSES,
    Bridges,
    Followed,
    SeenBefore,
    edges_of,
)
from robot.mapping.redundant import without_redundant
from robot.mapping.refinement import refined
from robot.mapping.seen_floor import SeenFloor
from robot.mapping.shades import shaded
from robot.mapping.sketch import Sketch
from robot.mapping.stroke_fitting import FINE_SPACING, SPACING, fit_stroke
from robot.mapping.strokes import Stroke, Strokes
from robot.mapping.tape_map import MappingError, TapeMap
from robot.mapping.tidying import tidied
from robot.mapping.tracing import MiddleCells, Middles, trace

WINDOW, WINDOW_SHARE = 8, 0.015
"""The window grows by at least the first [pictures], and by at least the second, a share of all.
Long drives are adjusted less often, because each adjustment is of the whole drive."""
START_SD, LOOSE_SD = np.array([1e-4, 1e-4, 1e-4]), np.array([1e-3, 1e-3, 3e-3])
"""The map begins where the robot does; it is held there less while it grows [m, m, rad]."""
WHEELS_SD = np.array([0.02, 0.02, 0.03])
"""Standard deviations of radii and separation of a robot that is as described."""
KNOWN_SD = 1e-3
"""Standard deviations of its other unknowns, as a share of those of a robot built by hand."""
RULER_SD, HELD_SD = 1e-4, 1e-6
"""Standard deviation of the tape's width where it is the only ruler [m]. While a map is adjusted
the width is held, by the second: thousands of edges that lie a little beside rough strokes would
stretch the ruler, and the whole map with it. The map is as uncertain as the first makes it."""
MOST_GATE = 0.12
"""Edges farther from known ones than this are new [m]; than ``LEAST_GATE``, if the pose is exactly
known."""
AHEAD = 0.4
"""How far ahead most edges are seen [m]."""
LEAST_MATCHED = 0.2
"""A picture tells where the robot is if this share of its edges lies on known ones."""
LEAST_TURN = 1.0
"""The wheels have to turn at least this far [rad]."""
ROUNDS = 8
"""How often strokes get more nodes, or are cut at corners, at most."""


class AdjustmentStage(NamedTuple):
    """How an adjustment is made."""

    gate: float
    """Edges farther from strokes than this do not count [m]."""
    doubt: float
    """Factor on the edges' standard deviations."""
    most: int
    """Most iterations."""


GROWING = AdjustmentStage(0.03, 8.0, 3)
"""While the map grows, strokes are rough."""
WHOLE = (AdjustmentStage(0.03, 1.0, 15), AdjustmentStage(0.02, 1.0, 15))
"""Of the whole drive, one after the other."""
LAST = (AdjustmentStage(0.02, 1.0, 60),)
"""The last one: a weak motion takes many steps."""


class Mapper:
    """Draws the map of one drive."""

    def __init__(
        self,
        log: DriveLog,
        spec: RobotSpec,
        width: float,
        start: Pose2 = Pose2(),
        *,
        calibrate: bool = False,
    ) -> None:
        """Prepare a drive on tape of a width [m], that begins at a pose in the map.

        A robot that nobody has calibrated is calibrated along with it; then the tape's width is the
        only ruler.

        Raises:
            MappingError: the drive shows no tape, or the robot stood still.
        """
        self._spec, self._width = spec, width
        self._nothing = Strokes.of((), width)
        self._kept = np.zeros(1, np.intp)
        self._next, self._drawn = 1, 0
        self._bridges = Bridges()
        self._passed: Followed | None = None
        self._is_tied = False
        self._before: SeenBefore
        self.extend(log)
        self._start = start.to_array()
        self._calibrate = calibrate
        self._sd = PRIORS.copy() if calibrate else KNOWN_SD * PRIORS
        if calibrate:
            self._sd[TAPE] = HELD_SD
        else:
            self._sd[[LEFT, RIGHT, SEPARATION]] = WHEELS_SD
        self._state = DriveEstimate(np.zeros(COUNT), self._start[None].copy(), np.zeros((1, 2)))
        self._covariance = np.diag(START_SD**2)
        self._strokes = self._nothing
        self._solution: Solution | None = None

    def extend(self, log: DriveLog) -> None:
        """Take the drive with what was added since; the map so far is kept.

        Raises:
            MappingError: the drive shows no tape, or the robot stood still.
        """
        _check(log)
        self._every = log.some(moving(log, self._spec))
        self._keep(self._kept)

    def _keep(self, kept: NDArray[np.intp]) -> None:
        """Let the drive that is adjusted be of some of its pictures."""
        self._kept = kept
        self._log = self._every.some(kept)
        self._seen = Sightings.of_edges(self._log, self._spec, self._nothing.edges)

    def run(self, report: Callable[[float], None] = lambda seconds: None) -> TapeMap:
        """Map the whole drive.

        Args:
            report: called after each window with how much of the drive is mapped [s].

        Raises:
            MappingError: nothing that was seen is tape.
            CalibrationError: no path explains the drive.
        """
        self.catch_up(report)
        rest = len(self._every.stamps) - self._next
        if rest:
            # A few are only laid on the strokes, because the whole drive is adjusted below.
            self._take(self._followed(self._next, self._next + rest))
            if self._solution is None or rest >= WINDOW:
                self._draw()
        log = self._log
        # The first pictures of a robot that is not known yet were laid out wrongly.
        self._trace(FINE_SPACING, rough=self._calibrate)
        if not self._strokes.traced:
            raise MappingError("the pictures show too little tape for a map")
        if self._calibrate:
            self._adjust(WHOLE)
            self._trace(FINE_SPACING)
        solution = self._refined(self._adjust(WHOLE))
        rays = RaysOnFloor.of(log, self._spec, self._state)
        own = without_redundant(self._strokes, solution.misses)
        real = [stroke for stroke in own if is_tape(stroke, self._width, rays)]
        kept = Strokes.of(real, self._width)
        whole = joined(kept, rays)
        if whole is not kept or len(real) < len(self._strokes.traced):
            self._strokes = whole
            self._refined(self._adjust(WHOLE[-1:]))
        solution, quality = self._settled()
        if self._calibrate and quality.contradictions:
            solution, quality = self._with_more_corners(solution, quality)
        rays = RaysOnFloor.of(log, self._spec, self._state)
        tidy = tidied(without_gaps(self._strokes, rays), rays)
        more = find_lengthwise(tidy.strokes, self._width, rays)
        if more.strokes:
            every = Strokes.of(self._strokes.each + more.strokes, self._width)
            tidy = tidied(without_gaps(joined(every, rays), rays), rays)
        return TapeMap(
            shaded(tidy, self._width, rays),
            more.others,
            self._strokes,
            solution,
            log.stamps,
            self._adjustment().step_errors(self._state),
            BareFloor.of(tidy.strokes, self._width, rays),
            SeenFloor.of(rays),
            rays,
            quality,
        )

    def _settled(self) -> tuple[Solution, FitQuality]:
        """Adjust the whole drive once more, held where it began, and ask how well it fits."""
        solution = self._adjust(LAST, START_SD)
        if self._calibrate:
            return self._by_ruler(solution)
        # The camera is held as described, which nobody has measured.
        measured = np.where(self._sd == KNOWN_SD * PRIORS, PRIORS, self._sd)
        return solution, quality_of(solution, measured)

    def _with_more_corners(
        self, solution: Solution, quality: FitQuality
    ) -> tuple[Solution, FitQuality]:
        """Return what bends would have it that are corners, if only so nothing is contradicted.

        A corner that was taken for a bend pulls the scale until it looks like one, so it is looked
        for as where the path is rough.
        """
        before = copy(self)
        self._strokes = cut_at_corners(self._strokes, rough=True)
        if self._strokes is before._strokes:
            return solution, quality
        try:
            self._refined(self._adjust(WHOLE))
            other, doubt = self._settled()
        except CalibrationError:
            doubt = quality
        if doubt.contradictions:
            self._strokes, self._state = before._strokes, before._state
            self._covariance, self._solution = before._covariance, before._solution
            return solution, quality
        return other, doubt

    def _by_ruler(self, solution: Solution) -> tuple[Solution, FitQuality]:
        """Return a solution as uncertain as its ruler is, and how well it fits.

        The tape's width counts there as the edges would have it if it were not held.
        """
        sd = self._sd.copy()
        sd[TAPE] = RULER_SD
        adjustment = self._adjustment(START_SD)
        state = replace(self._state, map=self._strokes.offsets)
        weights = Weights(sd=sd, gate=LAST[-1].gate)
        free = adjustment.solve(state, weights, LAST[-1].most, solution.misses.pixels)
        values = solution.state.values.copy()
        values[TAPE] = free.state.values[TAPE]
        ended = replace(solution, state=replace(solution.state, values=values))
        unlearnt = not_learnt(np.sqrt(np.diag(free.covariance)[:COUNT]))
        quality = quality_of(ended, sd, unlearnt)
        return replace(solution, covariance=free.covariance), quality

    def _refined(self, solution: Solution) -> Solution:
        """Give the strokes the nodes that they need, cut them at corners, and adjust again."""
        for _ in range(ROUNDS):
            finer = refined(self._strokes, solution.misses)
            if finer is self._strokes:
                # With all nodes that help, a stroke shows whether it is bent, or has a corner.
                finer = cut_at_corners(self._strokes)
            if finer is self._strokes:
                break
            self._strokes = finer
            solution = self._adjust(WHOLE[-1:])
        return solution

    @property
    def mapped(self) -> int:
        """How many of the pictures that show a motion are mapped."""
        return 0 if self._solution is None else self._next

    @property
    def rays(self) -> RaysOnFloor:
        """The rays of the pictures that are mapped, on the floor."""
        return RaysOnFloor.of(self._log, self._spec, self._state)

    def catch_up(self, report: Callable[[float], None] = lambda seconds: None) -> None:
        """Map the drive up to its last whole window of pictures.

        Raises:
            CalibrationError: no path explains the drive.
        """
        stamps = self._every.stamps
        while (until := self._next + self._window) <= len(stamps):
            self.grow(until)
            report(float(stamps[until - 1] - stamps[0]))

    @property
    def _window(self) -> int:
        """How many pictures are followed before it is asked whether they bring something new."""
        return WINDOW if self._passed else max(WINDOW, int(WINDOW_SHARE * len(self._kept)))

    def sketch(self) -> Sketch | None:
        """Return the map as far as it is drawn; None before the first window."""
        if self._solution is None:
            return None
        errors = self._adjustment().step_errors(self._state)
        drawn = replace(self._solution, state=self._state)
        last_pose = None if self._passed is None else self._passed.poses[-1]
        stamp = float(self._every.stamps[self._next - 1])
        return Sketch.of(self._strokes, drawn, self._log.stamps, errors, (stamp, last_pose))

    def grow(self, until: int) -> None:
        """Follow the drive to its picture of a number, and adjust all of it if that brings much."""
        followed = self._followed(self._next, until)
        passes = 0
        if self._solution is not None:
            passes = self._before.passes(followed, float(self._every.stamps[self._next]))
        known = passes >= PASSES and not followed.is_pushed
        if known and (self._passed is not None or self._is_tied):
            self._passed, self._next = followed, until
            return
        self._take(followed)
        self._is_tied = followed.is_tied
        waiting = len(self._kept) - self._drawn
        if not passes or waiting >= max(WINDOW, DEFERRED * self._drawn):
            self._draw()

    def _draw(self) -> None:
        self._trace(rough=True)
        matched = self._adjust((GROWING,)).misses
        near = matched.picture[np.abs(matched.metres) < LEAST_GATE]
        lying = np.bincount(near, minlength=len(self._kept)) + matched.near_ends
        self._drawn = len(self._kept)
        seen, poses = edges_of(self._log), self._state.poses
        self._before = SeenBefore(poses, self._log.stamps, seen, lying)

    def _take(self, followed: Followed) -> None:
        """Keep the pictures that follow; and those before them that were passed over last."""
        count, state = len(followed.poses), self._state
        first, poses = self._next, followed.poses
        if self._passed is not None:
            # What is new may have begun there: the wheels say how the robot came here.
            first -= len(self._passed.poses)
            poses = np.vstack([self._passed.poses, poses])
            if first > self._kept[-1] + 1:
                ends = np.vstack([state.poses[-1], poses[0]])
                self._bridges = self._bridges.and_one(
                    len(self._kept) - 1, ends, self._passed.first_covariance
                )
            self._passed = None
        self._next += count
        self._keep(np.concatenate([self._kept, np.arange(first, self._next)]))
        slip = np.vstack([state.slip, np.zeros((len(poses), 2))])
        self._state = replace(state, poses=np.vstack([state.poses, poses]), slip=slip)
        self._covariance = followed.covariance

    def _adjustment(self, start_sd: Array = LOOSE_SD) -> MapAdjustment:
        seen, motion = self._seen, self._motion
        covariance = np.diag(start_sd**2)
        return MapAdjustment(seen, motion, self._strokes, self._start, covariance, self._bridges)

    @property
    def _motion(self) -> WheelMotion:
        return WheelMotion.of(self._log, self._spec, self._bridges.before)

    def _followed(self, first: int, until: int) -> Followed:
        """Return where the pictures between two numbers were taken, by wheels and strokes."""
        state, passed = self._state, self._passed
        pose = begin_pose = state.poses[-1] if passed is None else passed.poses[-1]
        covariance = self._covariance if passed is None else passed.covariance
        slip = np.zeros((until - first, 2))
        if passed is None:
            slip[0] = state.slip[-1]
        log = self._every.between(first - 1, until)
        motion = WheelMotion.of(log, self._spec)
        steps, _ = motion.steps(state.values, slip)
        edges = self._strokes.edges
        seen = Sightings.of_edges(log.since(1), self._spec, edges)
        floor = seen.floor_points(state.values, motion.twists(state.values)[1:])
        poses = np.zeros((until - first, 3))
        covariances = []
        for k, step in enumerate(steps):
            pose, covariance = predicted(pose, covariance, step)
            if self._strokes.traced:
                reach = np.sqrt(np.trace(covariance[:2, :2]) + AHEAD**2 * covariance[2, 2])
                gate = min(MOST_GATE, LEAST_GATE + 3 * float(reach))
                place = seen.part(k, k + 1), floor.part(k, k + 1)
                pose, covariance = laid(pose, covariance, *place, state.values, gate, LEAST_MATCHED)
            poses[k] = pose
            covariances.append(covariance)
        lying = np.zeros(len(poses), np.intp)
        if self._strokes.traced:
            matched = misses(seen, floor, poses, state.values, LEAST_GATE)
            lying = np.bincount(matched.picture, minlength=len(poses)) + matched.near_ends
        shown = edges_of(log.since(1))
        return Followed(poses, covariance, covariances[0], shown, lying, begin_pose, steps)

    def _trace(self, spacing: float = SPACING, *, rough: bool = False) -> None:
        """Draw the strokes anew, from where the path lies by now, with nodes at a distance [m]."""
        state = self._state
        twists = self._motion.twists(state.values, state.slip)
        points = self._seen.points(state.values, twists)
        middles = Middles.of(points, state.poses, self._width)
        least = 2 if len(self._kept) <= 2 * WINDOW else 3
        # While the path is rough, what was seen a few times may be a second copy of other tape.
        cells = MiddleCells.of(middles, least, sparse=spacing == FINE_SPACING)
        self._strokes = Strokes.of(_traced(cells, spacing, rough=rough), self._width)

    def _adjust(self, stages: Sequence[AdjustmentStage], start_sd: Array = LOOSE_SD) -> Solution:
        last, count = self._solution, len(self._kept)
        errors = last.misses.pixels if last is not None and len(last.state.poses) == count else None
        for stage in stages:
            state = replace(self._state, map=self._strokes.offsets)
            weights = Weights(sd=self._sd, gate=stage.gate, doubt=stage.doubt)
            adjustment = self._adjustment(start_sd)
            solution = adjustment.solve(state, weights, stage.most, errors)
            errors = solution.misses.pixels
            moved = self._strokes.moved_by(solution.state.map)
            solution, self._strokes = moved_to_start(solution, moved, self._start)
            self._state, self._covariance = solution.state, solution.pose_covariance
        self._solution = solution
        return solution


def _check(log: DriveLog) -> None:
    if len(log.stamps) < 2 or not np.isfinite(log.pixels).any():
        raise MappingError("no picture of the drive shows tape of this width")
    if np.ptp(log.wheel_angles, axis=0).max() < LEAST_TURN:
        raise MappingError("the robot stood still; it has to drive")


def _traced(cells: MiddleCells, spacing: float, *, rough: bool) -> tuple[Stroke, ...]:
    strokes = []
    for line in trace(cells):
        closed = bool(np.array_equal(line[0], line[-1]))
        pieces = at_corners(line, closed, rough=rough)
        ring = closed and pieces[0] is line
        strokes += [fit_stroke(piece, ring, spacing) for piece in pieces]
    return tuple(stroke for stroke in strokes if stroke is not None)
