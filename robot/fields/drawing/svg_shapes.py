"""Walks through a drawing as a browser paints it, and returns its shapes.

What a browser would paint and this program cannot (pictures, gradients, masks ...) is refused by
name; text is left out, and noted. What a browser does not paint is passed over, whatever it is.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from robot.fields.drawing import outlines
from robot.fields.drawing.drawn_elements import UNDRAWN, is_meant, refuse, shows_nothing
from robot.fields.drawing.question import ANSWER, LEFT_OUT, TEXTS
from robot.fields.drawing.selectors import Element, local_name
from robot.fields.drawing.shapes import MAX_MM, Fade, Page, Shape, scale_of, unit_box
from robot.fields.drawing.strokes import Pen, Polyline
from robot.fields.drawing.style_sheets import ATTRIBUTE_ONLY
from robot.fields.drawing.styles import Reference, Style
from robot.fields.drawing.svg_document import Document, link_of, pen
from robot.fields.drawing.svg_file import MAX_DEPTH, MAX_ELEMENTS, is_svg
from robot.fields.drawing.svg_page import Viewport, fitted, page_size, view_box
from robot.fields.drawing.svg_values import Ink, Length, SvgError, colour, length, shown
from robot.geometry import Array

MAX_POINTS = 20_000
MAX_CLIPS = 8
"""Most clips of clips."""

_CLIP = Ink(0.0, 1.0)
"""What the shapes of a clip are painted with, whatever their own paint is."""


@dataclass(frozen=True, slots=True, eq=False)
class _Spot:
    """Where an element is drawn, and what it inherits there."""

    style: Style
    view: Viewport
    depth: int = 0
    size: dict[str, Length] = field(default_factory=dict)
    """Width and height that a <use> gives to what it shows."""
    top: Element | None = None
    """What the innermost <use> around it shows."""
    clips: int = 0
    """How many clips of each other this is within; 0 if it is painted."""


def read_page(root: Element, tolerance: float) -> Page:
    """Read the shapes; curves and their strokes are within the tolerance [mm] on the page.

    Raises:
        SvgError: a part of the drawing cannot be understood; the message says what is valid.
    """
    document = Document(root)
    style = document.own_style(root)
    size = page_size(root, style)
    if style.has("transform") or style.has(ATTRIBUTE_ONLY["transform"]):
        raise SvgError("the outermost <svg> has a transform; valid is one of a <g> within it")
    background = colour(style.raw("background-color") or style.raw("background"))
    with np.errstate(all="ignore"):  # numbers that are not finite are refused
        walk = _Walk(document, tolerance, size.pixel)
        shapes = walk.all_of(_Spot(style, size.viewport))
    return Page(
        size=size,
        shapes=shapes,
        background=background if isinstance(background, Ink) else None,
        start=root.get("data-start", ""),
        tape=root.get(ANSWER, ""),
        notes=dict.fromkeys([LEFT_OUT] if walk.texts else [], TEXTS)
        | {name: text for name, text in root.items() if name.startswith("data-")},
        hairlines=walk.hairlines,
    )


class _Walk:
    """One walk through a document."""

    def __init__(self, document: Document, tolerance: float, pixel: float) -> None:
        self._document = document
        self._tolerance = tolerance
        self._pixel = pixel
        self.hairlines = False
        """Whether lines had strokes of no width."""
        self.texts = False
        self._elements = self._points = self._groups = 0
        self._clips: dict[tuple[str, bytes], shapely.Geometry] = {}

    def all_of(self, spot: _Spot) -> tuple[Shape, ...]:
        """Return all shapes of the document, in the order of painting."""
        if spot.style["display"] == "none":
            return ()
        return self._affected(self._inside(self._document.root, spot), spot)

    def _inside(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        return tuple(shape for child in element for shape in self._drawn(child, spot))

    def _drawn(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        """Return the shapes of an element where it stands."""
        if not is_svg(element) or local_name(element)[1] in UNDRAWN or not is_meant(element):
            return ()
        return self._placed(element, spot)

    def _placed(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        self._elements += 1
        if self._elements > MAX_ELEMENTS:
            raise SvgError(f"more than {MAX_ELEMENTS} elements, counting each use; use fewer")
        if spot.depth > MAX_DEPTH:
            raise SvgError(f"elements nested (or using each other) deeper than {MAX_DEPTH}")
        style = self._document.style(element, spot.style, spot.top)
        if style["display"] == "none" or (style["opacity"] == 0 and not spot.clips):
            return ()
        view = spot.view.transformed(style)
        inner = replace(spot, style=style, view=view, depth=spot.depth + 1)
        return self._affected(self._content(element, inner), inner)

    def _content(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        name = local_name(element)[1]
        if name in outlines.SHAPES:
            return self._shape(element, name, spot)
        if name in ("g", "a", "svg", "symbol", "switch"):
            # In a clip, browsers take shapes alone.
            return () if spot.clips else self._group(element, name, spot)
        if name == "use":
            return self._used(element, spot)
        if not shows_nothing(element, name, spot.style) and (name != "text" or spot.clips):
            refuse(name)
        self.texts |= name == "text" and bool("".join(element.itertext()).strip())
        return ()

    def _group(self, element: Element, name: str, spot: _Spot) -> tuple[Shape, ...]:
        if name in ("g", "a"):
            return self._inside(element, spot)
        if name == "switch":
            meant = [child for child in element if is_svg(child) and is_meant(child)]
            return tuple(shape for child in meant[:1] for shape in self._drawn(child, spot))
        return self._nested(element, spot)

    def _used(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        target = self._document.linked(element)
        if target is None:
            raise SvgError(
                f"<use> of {shown(link_of(element))}; valid is # and the id of an element in the "
                "drawing"
            )
        if local_name(target)[1] in UNDRAWN and local_name(target)[1] != "symbol":
            return ()
        x, y = (spot.view.dimension(spot.style, name) or 0.0 for name in ("x", "y"))
        size = {
            name: spot.style[name]
            for name in ("width", "height")
            if spot.style.has(name) and isinstance(spot.style[name], Length)
        }
        view = spot.view.within(np.array([[1.0, 0.0, x], [0.0, 1.0, y]]))
        return self._placed(target, replace(spot, view=view, size=size, top=target))

    def _nested(self, element: Element, spot: _Spot) -> tuple[Shape, ...]:
        """Return the shapes of an <svg> or a <symbol>, which has a viewport of its own."""
        style, view = spot.style, spot.view
        sides = []
        for name in ("width", "height"):
            written = spot.size.get(name) or (style[name] if style.has(name) else "auto")
            whole = Length(100.0, "%") if isinstance(written, str) else written
            sides.append(view.units(name, whole))
        width, height = sides
        if not (width > 0 and height > 0):
            return ()
        x, y = (view.dimension(style, name) or 0.0 for name in ("x", "y"))
        frame = view.within(np.array([[1.0, 0.0, x], [0.0, 1.0, y]]))
        inner = replace(frame, width=width, height=height)
        if (box := view_box(element)) is not None:
            fit = fitted(box, (width, height), element.get("preserveAspectRatio", ""))
            inner = replace(frame.within(fit), width=box[2], height=box[3])
        shapes = self._inside(element, replace(spot, view=inner, size={}))
        if style["overflow"] in ("visible", "auto"):
            return shapes
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        outline = shapely.Polygon(corners @ frame.matrix[:, :2].T + frame.matrix[:, 2])
        return tuple(shape.clipped(outline) for shape in shapes)

    # --- one shape -------------------------------------------------------------------------------

    def _shape(self, element: Element, name: str, spot: _Spot) -> tuple[Shape, ...]:
        style, view = spot.style, spot.view
        if style["visibility"] != "visible":
            return ()
        fill: Ink | None = _CLIP
        stroke: Ink | None = None
        rule = style["clip-rule" if spot.clips else "fill-rule"]
        if not spot.clips:
            fill = self._document.ink(style, "fill")
            stroke = self._document.ink(style, "stroke")
            self._refuse_markers(name, style)
            if stroke is not None and style["stroke-width"].value == 0:
                # A shape that is filled, too, shows; a line cannot be.
                self.hairlines |= fill is None or name == "line"
                stroke = None
        scale = scale_of(view.matrix)
        if scale == 0 or (fill is None and stroke is None):
            return ()
        tip = pen(style, view) if stroke else Pen(0.0)
        fixed = stroke is not None and style["vector-effect"] == "non-scaling-stroke"
        # A dash may end anywhere; its cap is square to a chord instead of to the curve.
        tolerance = self._tolerance / scale / (16 if tip.dashes else 1)
        half = tip.width / 2 * (self._pixel / scale if fixed else 1.0)
        paths = outlines.subpaths(name, _points_of(element, name, style), _lengths(element, spot))
        shape = Shape(
            lines=tuple(outlines.polylines(paths, half, tolerance)),
            page_from_shape=view.matrix,
            fill=fill,
            even_odd=rule == "evenodd",
            stroke=stroke,
            pen=tip,
            stroke_first=style["paint-order"],
        )
        self._count_points(shape)
        return (_on_screen(shape, self._pixel) if fixed else shape,)

    def _refuse_markers(self, name: str, style: Style) -> None:
        if name in ("path", "line", "polyline", "polygon"):
            for marker in ("marker-start", "marker-mid", "marker-end"):
                self._document.refuse_effect(style, marker)

    def _count_points(self, shape: Shape) -> None:
        places = shape.places()
        if not all((np.abs(place) <= MAX_MM).all() for place in places):
            raise SvgError(f"a shape lies further out than {MAX_MM / 1e6:g} km")
        self._points += sum(map(len, places))
        if self._points > MAX_POINTS:
            raise SvgError(f"more than {MAX_POINTS} points along its lines; draw less finely")

    # --- what holds for an element as a whole ----------------------------------------------------

    def _affected(self, shapes: tuple[Shape, ...], spot: _Spot) -> tuple[Shape, ...]:
        """Return the shapes of an element after its clip and its opacity."""
        style = spot.style
        if not shapes:
            return ()
        for name in ("mix-blend-mode", "rotate", "scale", "translate", "offset-path", "zoom"):
            _ = style[name]  # which refuses what is not understood
        if isinstance(style["clip-path"], Reference):
            area = self._clip(style["clip-path"], shapes, spot)
            if area is not None:
                shapes = tuple(shape.clipped(area) for shape in shapes)
        if spot.clips:
            return shapes
        for name in ("mask", "filter"):
            self._document.refuse_effect(style, name)
        if style["opacity"] < 1:
            self._groups += 1
            fade = Fade(style["opacity"], self._groups)
            shapes = tuple(replace(shape, fades=(fade, *shape.fades)) for shape in shapes)
        return shapes

    def _clip(
        self, link: Reference, shapes: tuple[Shape, ...], spot: _Spot
    ) -> shapely.Geometry | None:
        """Return what a clip leaves of the page [mm]; None if there is no such clip."""
        element = self._document.referred("clip-path", link)
        if local_name(element)[1] != "clipPath":
            return None
        if spot.clips > MAX_CLIPS:
            raise SvgError(f"clips of clips deeper than {MAX_CLIPS}")
        style, view = self._document.own_style(element), spot.view
        if element.get("clipPathUnits") == "objectBoundingBox":
            view = view.within(unit_box(shapes, view.matrix))
        key = link.id, view.matrix.tobytes()
        if key not in self._clips:
            self._clips[key] = self._clip_area(element, style, shapes, replace(spot, view=view))
        return self._clips[key]

    def _clip_area(
        self, element: Element, style: Style, shapes: tuple[Shape, ...], spot: _Spot
    ) -> shapely.Geometry:
        view = spot.view.transformed(style)
        inner = _Spot(style, view, spot.depth, clips=spot.clips + 1)
        parts = [shape.filled_area() for shape in self._inside(element, inner)]
        area = shapely.union_all(parts)
        if isinstance(style["clip-path"], Reference):
            own = self._clip(style["clip-path"], shapes, replace(inner, view=spot.view))
            area = area if own is None else shapely.intersection(area, own)
        return area


def _points_of(element: Element, name: str, style: Style) -> str:
    data: str = style["d"] if name == "path" else element.get("points", "")
    return data


def _lengths(element: Element, spot: _Spot) -> outlines.Dimension:
    """Return how the lengths of a shape are looked up."""

    def dimension(name: str) -> float | None:
        if name not in ("x1", "y1", "x2", "y2"):
            return spot.view.dimension(spot.style, name)
        text = element.get(name, "0")
        written = length(text)
        if written is None:
            raise SvgError(f"{name} is {shown(text)}; valid is a number")
        return spot.view.units(name, written)

    return dimension


def _on_screen(shape: Shape, pixel: float) -> Shape:
    """Return the shape in pixels of the page, in which a ``non-scaling-stroke`` is drawn."""
    points: list[Array] = [place / pixel for place in shape.places()]
    lines = (Polyline(place, line.closed) for place, line in zip(points, shape.lines, strict=True))
    page = np.array([[pixel, 0.0, 0.0], [0.0, pixel, 0.0]])
    return replace(shape, lines=tuple(lines), page_from_shape=page)
