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

from robot.calibration.adjustment import (
    CalibrationError,
    DriveEstimate,
    Solution,
    Weights,
    quality_of,
)
from robot.calibration.calibrate import not_learnt
from robot.calibration.drive_log import DriveLog
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
        self._log = log.some(moving(log, self._spec))
        self._seen = Sightings.of_edges(self._log, self._spec, self._nothing.edges)

    def run(self, report: Callable[[float], None] = lambda seconds: None) -> TapeMap:
        """Map the whole drive.

        Args:
            report: called after each window with how much of the drive is mapped [s].

        Raises:
            MappingError: nothing that was seen is tape.
            CalibrationError: no path explains the drive.
        """
        log, total = self._log, len(self._log.stamps)
        self.catch_up(report)
        if self._solution is None or total - self.mapped >= WINDOW:
            self.grow(total)
        elif self.mapped < total:
            # These few are only laid on the strokes, because the whole drive is adjusted below.
            self._state = self._followed(*self._part(total))
        # The first pictures of a robot that is not known yet were laid out wrongly.
        self._trace(total, FINE_SPACING, rough=self._calibrate)
        if not self._strokes.traced:
            raise MappingError("the pictures show too little tape for a map")
        if self._calibrate:
            self._adjust(total, WHOLE)
            self._trace(total, FINE_SPACING)
        solution = self._refined(self._adjust(total, WHOLE))
        rays = RaysOnFloor.of(log, self._spec, self._state)
        own = without_redundant(self._strokes, solution.misses)
        real = [stroke for stroke in own if is_tape(stroke, self._width, rays)]
        kept = Strokes.of(real, self._width)
        whole = joined(kept, rays)
        if whole is not kept or len(real) < len(self._strokes.traced):
            self._strokes = whole
            self._refined(self._adjust(total, WHOLE[-1:]))
        solution, quality = self._settled(total)
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
            self._adjustment(total).step_errors(self._state),
            BareFloor.of(tidy.strokes, self._width, rays),
            SeenFloor.of(rays),
            rays,
            quality,
        )

    def _settled(self, total: int) -> tuple[Solution, FitQuality]:
        """Adjust the whole drive once more, held where it began, and ask how well it fits."""
        solution = self._adjust(total, LAST, START_SD)
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
        total, before = len(self._log.stamps), copy(self)
        self._strokes = cut_at_corners(self._strokes, rough=True)
        if self._strokes is before._strokes:
            return solution, quality
        try:
            self._refined(self._adjust(total, WHOLE))
            other, doubt = self._settled(total)
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
        adjustment = self._adjustment(len(self._log.stamps), START_SD)
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
            solution = self._adjust(len(self._log.stamps), WHOLE[-1:])
        return solution

    @property
    def mapped(self) -> int:
        """How many of the pictures that are used are mapped."""
        return 0 if self._solution is None else len(self._state.poses)

    @property
    def rays(self) -> RaysOnFloor:
        """The rays of the pictures that are mapped, on the floor."""
        return RaysOnFloor.of(self._log.until(self.mapped), self._spec, self._state)

    def catch_up(self, report: Callable[[float], None] = lambda seconds: None) -> None:
        """Map the drive up to its last whole window of pictures.

        Raises:
            CalibrationError: no path explains the drive.
        """
        stamps = self._log.stamps
        while (count := self.mapped + max(WINDOW, int(WINDOW_SHARE * self.mapped))) <= len(stamps):
            self.grow(count)
            report(float(stamps[count - 1] - stamps[0]))

    def sketch(self) -> Sketch | None:
        """Return the map as far as it is drawn; None before the first window."""
        if self._solution is None:
            return None
        errors = self._adjustment(self.mapped).step_errors(self._state)
        return Sketch.of(self._strokes, self._solution, self._log.stamps, errors)

    def grow(self, count: int) -> None:
        """Follow the drive to its picture of a number, and adjust all of it."""
        seen, motion = self._part(count)
        self._state = self._followed(seen, motion)
        self._trace(count, rough=True)
        self._adjust(count, (GROWING,))

    def _adjustment(self, count: int, start_sd: Array = LOOSE_SD) -> MapAdjustment:
        return MapAdjustment(*self._part(count), self._strokes, self._start, np.diag(start_sd**2))

    def _part(self, count: int) -> tuple[Sightings, WheelMotion]:
        return self._seen.part(0, count), WheelMotion.of(self._log.until(count), self._spec)

    def _followed(self, seen: Sightings, motion: WheelMotion) -> DriveEstimate:
        """Return the state with the poses of all pictures of the window."""
        state, covariance = self._state, self._covariance
        known, total = len(state.poses), len(motion.stamps)
        slip = np.vstack([state.slip, np.zeros((total - known, 2))])
        steps, _ = motion.steps(state.values, slip[:-1])
        # Those that are mapped stay where they are.
        seen = replace(seen.part(known, total), tape=self._strokes.edges)
        floor = seen.floor_points(state.values, motion.twists(state.values)[known:])
        poses = np.vstack([state.poses, np.zeros((total - known, 3))])
        for k in range(known, total):
            poses[k], covariance = predicted(poses[k - 1], covariance, steps[k - 1])
            if not self._strokes.traced:
                continue
            reach = np.sqrt(np.trace(covariance[:2, :2]) + AHEAD**2 * covariance[2, 2])
            gate = min(MOST_GATE, LEAST_GATE + 3 * float(reach))
            place = seen.part(k - known, k - known + 1), floor.part(k - known, k - known + 1)
            poses[k], covariance = laid(
                poses[k], covariance, *place, state.values, gate, LEAST_MATCHED
            )
        return replace(state, poses=poses, slip=slip)

    def _trace(self, count: int, spacing: float = SPACING, *, rough: bool = False) -> None:
        """Draw the strokes anew, from where the path lies by now, with nodes at a distance [m]."""
        seen, motion = self._part(count)
        state = self._state
        points = seen.points(state.values, motion.twists(state.values, state.slip))
        middles = Middles.of(points, state.poses, self._width)
        least = 2 if count <= 2 * WINDOW else 3
        # While the path is rough, what was seen a few times may be a second copy of other tape.
        cells = MiddleCells.of(middles, least, sparse=spacing == FINE_SPACING)
        self._strokes = Strokes.of(_traced(cells, spacing, rough=rough), self._width)

    def _adjust(
        self, count: int, stages: Sequence[AdjustmentStage], start_sd: Array = LOOSE_SD
    ) -> Solution:
        last = self._solution
        errors = last.misses.pixels if last is not None and len(last.state.poses) == count else None
        for stage in stages:
            state = replace(self._state, map=self._strokes.offsets)
            weights = Weights(sd=self._sd, gate=stage.gate, doubt=stage.doubt)
            adjustment = self._adjustment(count, start_sd)
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
