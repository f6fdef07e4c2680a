"""A map of tape that was drawn by driving, and how well it fits the drive."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from robot.calibration.adjustment import Solution
from robot.errors import BrickPoseError
from robot.estimation.fit_quality import FitQuality
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Array
from robot.mapping.agreement import Agreement
from robot.mapping.crossings import BareFloor
from robot.mapping.drawing import drawing
from robot.mapping.ends import RaysOnFloor
from robot.mapping.map_adjustment import node_sd
from robot.mapping.pushed import moved_at, push_remark
from robot.mapping.seen_floor import SeenFloor, occupancy
from robot.mapping.strokes import Stroke, Strokes
from robot.mapping.tidying import TidyStrokes

LEAST_SHARE = 0.7
"""A map fits if this share of the edges that were seen lies on its strokes."""
UNSURE = 0.01
"""Remarks name tape whose place is less certain than this [m]."""
LEAST_STEADINESS = 0.01
"""Least steadiness with which tape determines the pose in all directions."""
MOST_PLACES = 3
"""Most places that a remark names."""


class MappingError(BrickPoseError, ValueError):
    """The drive does not show enough of the floor; the message says why."""


@dataclass(frozen=True, eq=False)
class TapeMap:
    """A map, and the drive that it was drawn from."""

    tidy: TidyStrokes
    """The tape."""
    others: tuple[Array, ...]
    """Where rays met each dark thing that is not drawn, (n, 2) [m]."""
    measured: Strokes
    """The measurements of the tape, as adjusted."""
    solution: Solution = field(repr=False)
    """The drive."""
    stamps: Array = field(repr=False)
    """(k,) stamps of the pictures that were used [s]."""
    step_errors: Array = field(repr=False)
    """(k - 1, 3) differences of the steps from odometry, in standard deviations."""
    bare: BareFloor
    """Where bare floor was seen instead of the map's tape."""
    seen: SeenFloor = field(repr=False)
    """Where the camera has looked."""
    rays: RaysOnFloor = field(repr=False)
    """All rays of the drive."""
    quality: FitQuality
    """How well the drive fits, and a robot that was calibrated along with the map."""
    drawn: TidyStrokes | None = None
    """The tape as it was drawn, if people have changed it since."""

    def edited(self, tidy: TidyStrokes) -> TapeMap:
        """Return the map with strokes that people have changed, and what the drive says of them."""
        bare = BareFloor.of(tidy.strokes, self.measured.width, self.rays)
        return replace(self, tidy=tidy, bare=bare, drawn=self.drawn or self.tidy)

    @cached_property
    def agreement(self) -> Agreement | None:
        """How the edges that were seen lie on a map that people have changed; None if nobody has.

        Of one as it was drawn, the adjustment knows it (``solution``)."""
        if self.drawn is None:
            return None
        width = self.measured.width
        return Agreement.of(self.tidy.strokes, self.drawn.strokes, width, self.rays)

    @property
    def share(self) -> float:
        """Of the edges that were seen, the ones that lie on the map."""
        changed = 1.0 if self.agreement is None else self.agreement.share
        return min(1.0, self.solution.share * changed)

    @property
    def length(self) -> float:
        """Length of all tape [m]."""
        return sum(stroke.length for stroke in self.tidy.strokes)

    @property
    def node_sd(self) -> Array:
        """(n,) how uncertain each node of ``measured`` is across its stroke [m].

        The map begins where the robot began, so its places are less certain the farther they are.
        """
        return node_sd(self.measured, self.solution)

    @property
    def moved_at(self) -> float | None:
        """When the robot first moved otherwise than by its wheels [s]; None if it never did."""
        return moved_at(self.step_errors, self.solution.state.slip, self.stamps)

    @property
    def fits(self) -> bool:
        """Whether the map explains what was seen."""
        whole = self.moved_at is None and not self.bare.contradicts
        return self.share >= LEAST_SHARE and whole and not self.quality.contradictions

    @property
    def unseen_ends(self) -> Array:
        """(n, 2) ends of strokes that no picture showed [m]."""
        ends = [
            self.tidy.strokes[number].end(last)[0]
            for (number, last), end in self.tidy.ends.items()
            if end.sd > UNSURE
        ]
        return np.array(ends).reshape(-1, 2)

    @property
    def facts(self) -> tuple[str, ...]:
        """The report: what was drawn, and how well."""
        count, corners = len(self.tidy.strokes), len(self.tidy.corners)
        share = 100 * self.share
        median, largest = 1.96e3 * np.median(self.node_sd), 1.96e3 * self.node_sd.max()
        fit = f"{share:.0f} % of the edges that were seen lie on it"
        if self.drawn is not None:
            fit += ", as it was changed by hand"
        return (
            f"{count} strokes of tape, {self.length:.2f} m, with {corners} corners",
            fit,
            f"its tape is uncertain by {median:.1f} mm (95 %, median), and by {largest:.1f} mm at "
            "most",
            *(() if self.drawn is not None else self.quality.facts),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is wrong with the map, or may be wrong."""
        remarks = [*self._doubts, *self._by_hand]
        if self.bare.is_lost:
            remarks.append(
                f"{100 * self.bare.share:.0f} % of the rays across its tape saw bare floor there"
                f"{near(self.bare.places)}: the path was lost; drive so that tape stays in sight"
            )
        elif self.bare.contradicts:
            remarks.append(
                f"its tape{near(self.bare.places)} may not be there: many rays across it saw bare "
                "floor; drive past it once more, or delete it"
            )
        largest = float(1.96 * self.node_sd.max())
        if largest > UNSURE:
            remarks.append(
                f"some of its tape is uncertain by {1e3 * largest:.0f} mm: drive along it once "
                "more, and back to where the map began"
            )
        if self.moved_at is not None:
            remarks.append(push_remark(self.moved_at, is_noise=self.quality.is_noise))
        unseen = len(self.unseen_ends)
        if unseen:
            remarks.append(
                f"the map is incomplete: {unseen} ends of tape{near(self.unseen_ends)} were not "
                "seen; drive toward them, and where the tape goes on"
            )
        if steadiness(self.tidy.strokes) < LEAST_STEADINESS:
            remarks.append(
                "the tape looks the same when the robot is moved along it, so the path may be "
                "wrong by such a motion: lay a mark beside it, such as a stub"
            )
        if self.others:
            others = np.array([thing.mean(axis=0) for thing in self.others])
            remarks.append(
                f"the map is incomplete: something{near(others)} is not in it, a "
                "shadow, or tape that was seen from its end only; drive past it"
            )
        return tuple(remarks)

    @property
    def _by_hand(self) -> Iterator[str]:
        """Yield what is to be said of changes by hand."""
        if self.agreement is not None and len(self.agreement.lost):
            yield f"tape that was seen{near(self.agreement.lost)} is not in the map any more"
        changed = sum(stroke.by_hand for stroke in self.tidy.strokes)
        if changed:
            yield (
                f"{changed} of its strokes were moved or joined by hand: the intervals are not of "
                "what was changed"
            )

    @property
    def _doubts(self) -> Iterator[str]:
        """Yield what the adjustment says against itself."""
        if self.share < LEAST_SHARE:
            share = 100 * self.share
            yield f"the map does not fit: {share:.0f} % of the edges that were seen lie on it"
        yield from self.quality.remarks

    def cells(self, side: float) -> OccupancyGrid:
        """Return the map in cells with a side [m]; floor that no picture showed is unknown."""
        lines = [stroke.points for stroke in self.tidy.strokes]
        return occupancy(lines, self.measured.width, self.seen, side)

    def drawing(self, title: str) -> str:
        """Return the map as an SVG, for ``load_field``."""
        seen = self.seen.outlines(np.vstack([self.unseen_ends, *self.others]))
        words, fit = (*self.facts, *self.remarks), json.dumps(self.quality.table())
        path = self.solution.state.poses
        return drawing(self.tidy, self.measured.width, path, title, seen, words, fit)


def steadiness(strokes: Sequence[Stroke]) -> float:
    """Return how well tape determines the motion that it determines worst, 0 to 1.

    It is the ratio of the smallest to the largest eigenvalue of the information that centre lines
    give about a small motion; a turn counts by how far it moves the tape. It is 0 if some motion
    leaves all tape in place, such as a turn of a circle about its centre.
    """
    lines = [stroke.points for stroke in strokes]
    along = np.vstack([np.diff(line, axis=0) for line in lines])
    middle = np.vstack([(line[1:] + line[:-1]) / 2 for line in lines])
    length = np.hypot(*along.T)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
    # The ends of a long line determine a turn, too.
    points = np.vstack([middle - along / 3, middle, middle + along / 3])
    normals, weights = np.tile(left, (3, 1)), np.tile(length, 3)
    away = points - np.average(points, axis=0, weights=weights)
    size = np.sqrt(np.average((away**2).sum(axis=1), weights=weights))
    turn = (away[:, 0] * normals[:, 1] - away[:, 1] * normals[:, 0]) / size
    by_motion = np.column_stack([normals, turn]) * np.sqrt(weights)[:, None]
    values = np.linalg.eigvalsh(by_motion.T @ by_motion)
    return float(max(0.0, values[0]) / values[-1])


def near(places: Array) -> str:
    """Return the first of some places (n, 2) as text; empty without places."""
    some = ", ".join(f"({x:.2f}, {y:.2f}) m" for x, y in places[:MOST_PLACES])
    return f" at {some}" if some else ""
