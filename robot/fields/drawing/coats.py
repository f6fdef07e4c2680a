"""Turns the shapes of a drawing into coats of paint on the floor, in the map frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from typing import TypeAlias

import numpy as np
import shapely

from robot.fields.drawing.shapes import Fade, Page, Shape, moved
from robot.fields.drawing.strokes import fill_area, stroke_area
from robot.fields.drawing.svg_values import Ink, SvgError
from robot.fields.drawn_tape import Coat
from robot.fields.floor_picture import Layer

_Painted: TypeAlias = tuple[tuple[Fade, ...], Coat]
"""A coat, and the groups with an opacity in which it is, the outermost first."""

MOST_IN_GROUP = 200
"""Shapes of a group with an opacity: each is compared with each."""

WIDEST_MM = 1000.0
"""Of a stroke [mm]."""


def coats_of(page: Page, tolerance: float) -> list[Coat]:
    """Return what is painted, in order: each shape's fill, then its stroke; tolerance in mm.

    Raises:
        SvgError: a stroke is absurd.
    """
    painted: list[_Painted] = []
    if page.background is not None:
        painted.append(((), _background(page, page.background)))
    for shape in page.shapes:
        coats = list(_coats(shape, page, tolerance))
        ordered = reversed(coats) if shape.stroke_first else coats
        painted += [(shape.fades, coat) for coat in ordered]
    return [coat for _, coat in _faded(painted)]


def _background(page: Page, ink: Ink) -> Coat:
    area = shapely.box(0, 0, page.size.width, page.size.height)
    return Coat(Layer(_on_map(area, page), ink.grey, ink.alpha))


def _coats(shape: Shape, page: Page, tolerance: float) -> Iterator[Coat]:
    if shape.scale == 0 or not shape.lines:
        return
    if shape.fill:
        area = fill_area([line.points for line in shape.lines], shape.even_odd)
        yield Coat(_layer(area, shape, page, shape.fill))
    if shape.stroke:
        yield _stroke(shape, page, shape.stroke, tolerance)


def _stroke(shape: Shape, page: Page, ink: Ink, tolerance: float) -> Coat:
    widest = shape.pen.width * shape.scale
    if widest > WIDEST_MM:
        raise SvgError(f"a stroke is {widest:g} mm wide; valid is up to {WIDEST_MM:g}")
    matrix = shape.page_from_shape[:, :2]
    width = shape.pen.width * math.sqrt(abs(np.linalg.det(matrix))) / 1000
    within = tolerance / shape.scale
    try:
        area = shapely.union_all([stroke_area(line, shape.pen, within) for line in shape.lines])
    except ValueError as error:
        raise SvgError(str(error)) from error
    # An odd number of lengths is taken twice, so each is a dash once.
    pattern = shape.pen.dashes[:: 2 - len(shape.pen.dashes) % 2]
    dash = max(pattern, default=0.0) * width / shape.pen.width if width else 0.0
    return Coat(_layer(area, shape, page, ink), width, dash)


def _layer(area: shapely.Geometry, shape: Shape, page: Page, ink: Ink) -> Layer:
    on_page = moved(area, shape)
    # A clip that cuts nothing off changes no digit of a coordinate.
    if shape.clip is not None and not shapely.covers(shape.clip, on_page):
        on_page = shapely.intersection(shape.clip, on_page)
    return Layer(_on_map(on_page, page), ink.grey, ink.alpha)


def _on_map(area: shapely.Geometry, page: Page) -> shapely.Geometry:
    """Return an area of the page [mm] in the map frame [m]."""
    return shapely.transform(area, lambda points: (points - page.origin) * (0.001, -0.001))


def _faded(painted: list[_Painted]) -> list[_Painted]:
    """Return the coats after the opacities of their groups, the innermost first."""
    for depth in range(max((len(fades) for fades, _ in painted), default=0) - 1, -1, -1):
        groups = groupby(painted, key=lambda under: under[0][depth : depth + 1])
        painted = [
            (fades, coat)
            for fade, members in groups
            for fades, coat in (_group(list(members), depth) if fade else members)
        ]
    return painted


def _group(members: list[_Painted], depth: int) -> list[_Painted]:
    """Return the coats of one group: what is hidden within it does not shine through."""
    painted: list[Coat] = []
    coats = _joined([coat for _, coat in members])
    if len(coats) > MOST_IN_GROUP:
        raise SvgError(
            f"a group with an opacity has {len(coats)} shapes of different paint; valid are up to "
            f"{MOST_IN_GROUP}: give them the opacity, or none"
        )
    for coat in coats:
        layer, left = coat.layer, coat.layer.area
        mixed = []
        for place, under in enumerate(painted):
            if not shapely.intersects(under.layer.area, layer.area):
                continue
            outside = shapely.difference(under.layer.area, layer.area)
            painted[place] = replace(under, layer=replace(under.layer, area=outside))
            if layer.alpha < 1:
                shared = shapely.intersection(under.layer.area, layer.area)
                mixed.append(replace(under, layer=_mixed(under.layer, layer, shared)))
                left = shapely.difference(left, under.layer.area)
        painted += [*mixed, replace(coat, layer=replace(layer, area=left))]
    fades = members[0][0]
    opacity = fades[depth].opacity
    return [
        (fades[:depth], replace(coat, layer=replace(coat.layer, alpha=coat.layer.alpha * opacity)))
        for coat in painted
    ]


def _joined(coats: list[Coat]) -> list[Coat]:
    """Unite successive opaque coats of the same paint."""
    joined = []
    for same, run in groupby(
        coats, key=lambda under: (under.layer.grey, under.layer.alpha, under.width, under.dash)
    ):
        alike = list(run)
        if same[1] == 1:
            area = shapely.union_all([under.layer.area for under in alike])
            alike = [replace(alike[0], layer=replace(alike[0].layer, area=area))]
        joined += alike
    return joined


def _mixed(below: Layer, above: Layer, area: shapely.Geometry) -> Layer:
    """Return a layer that looks as two do, one over the other."""
    hidden = below.alpha * (1 - above.alpha)
    alpha = above.alpha + hidden
    return Layer(area, (above.grey * above.alpha + below.grey * hidden) / alpha, alpha)
