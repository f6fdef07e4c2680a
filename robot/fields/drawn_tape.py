"""The tape of a drawing: which strokes are tape, what they look like, and what of them is visible.

A dark stroke (brightness below a half) is dark tape. A light stroke on a floor that fills have made
dark is light tape. On such a floor, a dark stroke is tape only if it is much darker than the floor.
All tape of one brightness is united. Light paint hides dark tape that was painted before it, and
dark paint hides light tape.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from robot.fields.field import CONTRAST
from robot.fields.floor_picture import PAPER, Layer
from robot.geometry import Array
from robot.scanning.tape import Tape

HALF = PAPER / 2
"""Half the brightness of white."""
PLACES = 32
"""Largest number of points of a stroke at which the floor below it is looked at."""
BESIDE = 0.9
"""A stroke lies on a dark floor if the floor is dark below this share of those points."""


@dataclass(frozen=True, slots=True)
class Coat:
    """A stroke or a fill on the floor."""

    layer: Layer
    width: float | None = None
    """Width of a stroke [m]; a fill has none."""
    dash: float = 0.0
    """Length of a stroke's dashes [m]; 0 if it has none."""

    @property
    def is_light(self) -> bool:
        """Whether it hides dark tape."""
        return self.layer.grey * self.layer.alpha >= HALF

    @property
    def is_dark(self) -> bool:
        """Whether it hides light tape."""
        return (PAPER - self.layer.grey) * self.layer.alpha >= HALF


@dataclass(frozen=True)
class DrawnTape:
    """What of a drawing is tape."""

    area: shapely.Geometry
    """Visible tape in the map frame [m]."""
    kinds: tuple[Tape, ...]
    """Its kinds, that of the largest area first."""


def drawn_tape(coats: Sequence[Coat]) -> DrawnTape:
    """Return what is tape after all coats, which are given in the order of painting."""
    tape = [_tape_of(coat, ground) for coat, ground in zip(coats, _grounds(coats), strict=True)]
    covered: defaultdict[Tape, float] = defaultdict(float)
    for coat, kind in zip(coats, tape, strict=True):
        if kind is not None:
            covered[kind] += float(shapely.area(coat.layer.area))
    area = shapely.union_all([_visible(coats, tape, light) for light in (False, True)])
    return DrawnTape(area, tuple(sorted(covered, key=covered.__getitem__, reverse=True)))


def _tape_of(coat: Coat, ground: float) -> Tape | None:
    """Return the kind of tape that a coat is, on a floor of a grey level; None if it is no tape."""
    if coat.width is None:
        return None
    layer = coat.layer
    on_floor = layer.grey * layer.alpha + ground * (1 - layer.alpha)
    light = ground < HALF and on_floor >= HALF
    dark = on_floor < HALF and (ground >= HALF or ground - on_floor >= CONTRAST)
    return Tape(round(coat.width, 7), light, round(coat.dash, 7)) if light or dark else None


def _grounds(coats: Sequence[Coat]) -> list[float]:
    """Return the grey level below each coat: that of paper, except on fills that are dark."""
    places = [_places(coat) for coat in coats]
    owner = np.repeat(np.arange(len(coats)), [len(points) for points in places])
    points = np.concatenate(places) if places else np.empty((0, 2))
    levels = np.full(len(points), float(PAPER))
    tree = shapely.STRtree([shapely.Point(x, y) for x, y in points.tolist()])
    for number, coat in enumerate(coats):
        if coat.width is None and len(owner) and owner[-1] > number:
            shapely.prepare(coat.layer.area)
            inside = tree.query(coat.layer.area, predicate="contains_properly")
            later = inside[owner[inside] > number]
            levels[later] += coat.layer.alpha * (coat.layer.grey - levels[later])
    grounds = []
    ends = np.cumsum([len(seen) for seen in places])
    for below in np.split(levels, ends[:-1]) if coats else ():
        dark = len(below) > 0 and (below < HALF).mean() >= BESIDE
        grounds.append(float(np.median(below)) if dark else float(PAPER))
    return grounds


def _places(coat: Coat) -> Array:
    """Return points (n, 2) [m] along the outline of a stroke; none of a fill."""
    if coat.width is None:
        return np.empty((0, 2))
    outline = shapely.get_coordinates(coat.layer.area)
    if not len(outline):  # it shows nowhere
        return np.empty((0, 2))
    chosen: Array = outline[np.unique(np.linspace(0, len(outline) - 1, PLACES).astype(int))]
    return chosen


def _visible(coats: Sequence[Coat], tape: Sequence[Tape | None], light: bool) -> shapely.Geometry:
    """Return the area of light tape, or of dark tape, that is visible after all coats."""
    runs: list[tuple[bool, list[shapely.Geometry]]] = []
    for coat, kind in zip(coats, tape, strict=True):
        is_tape = kind is not None and kind.light == light
        if is_tape or (coat.is_dark if light else coat.is_light):
            if not runs or runs[-1][0] != is_tape:
                runs.append((is_tape, []))
            runs[-1][1].append(coat.layer.area)
    areas = [
        (is_tape, shapely.union_all(parts) if len(parts) > 1 else parts[0])
        for is_tape, parts in runs
    ]
    return _last_on_top(areas)[0] if areas else shapely.Polygon()


def _last_on_top(
    areas: Sequence[tuple[bool, shapely.Geometry]],
) -> tuple[shapely.Geometry, shapely.Geometry]:
    """Return the visible part of the tape among areas, and all paint that hides what is below.

    The areas are tape (true) or paint, in the order of painting; halves are put together.
    """
    nothing: shapely.Geometry = shapely.Polygon()
    if len(areas) == 1:
        is_tape, area = areas[0]
        return (area, nothing) if is_tape else (nothing, area)
    below, paint_below = _last_on_top(areas[: len(areas) // 2])
    above, paint_above = _last_on_top(areas[len(areas) // 2 :])
    # Paint hides only the tape that was painted before it.
    if not shapely.is_empty(below) and not shapely.is_empty(paint_above):
        below = shapely.difference(below, paint_above)
    tape = above if shapely.is_empty(below) else shapely.union_all([below, above])
    return tape, shapely.union_all([paint_below, paint_above])
