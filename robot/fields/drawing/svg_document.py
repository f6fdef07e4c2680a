"""A document's elements: by their ids, and with their styles."""

from __future__ import annotations

from robot.fields.drawing.selectors import Element, local_name
from robot.fields.drawing.strokes import Pen
from robot.fields.drawing.style_sheets import StyleSheet
from robot.fields.drawing.styles import ATTRIBUTES, NOTHING, Reference, Style
from robot.fields.drawing.svg_page import Viewport
from robot.fields.drawing.svg_values import Ink, Length, SvgError, colour, shown

LINK = "{http://www.w3.org/1999/xlink}href"


class Document:
    """A drawing's elements."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self._sheet = StyleSheet(root)
        self._trees = {root: self._sheet.declared(root, ATTRIBUTES, is_root=True)}
        self._parents = {child: parent for parent in root.iter() for child in parent}
        self._by_id: dict[str, Element] = {}
        for element in root.iter():
            if "id" in element.attrib:
                self._by_id.setdefault(element.attrib["id"], element)

    def style(self, element: Element, parent: Style | None, top: Element | None = None) -> Style:
        """Return the style of an element that inherits from another style.

        Args:
            element: the element.
            parent: what it inherits from.
            top: what a <use> shows, if the element is part of that.
        """
        if top is None or not self._sheet.has_rules:
            top = self.root
        if top not in self._trees:
            self._trees[top] = self._sheet.declared(top, ATTRIBUTES, is_root=False)
        return Style(self._trees[top][element], parent)

    def own_style(self, element: Element) -> Style:
        """Return the style of an element where it stands in the document."""
        parent = self._parents.get(element)
        return self.style(element, None if parent is None else self.own_style(parent))

    def referred(self, name: str, reference: Reference) -> Element:
        """Return the element that a property's value refers to.

        Raises:
            SvgError: there is no such element. A browser paints something else then, or nothing,
                which nobody can have meant.
        """
        element = self._by_id.get(reference.id)
        if element is None:
            raise SvgError(
                f"{name} is {shown(f'url(#{reference.id})')}, which is not in the drawing; valid "
                "are none, or # and the id of an element in it"
            )
        return element

    def linked(self, element: Element) -> Element | None:
        """Return the element that a link leads to; None if it leads nowhere."""
        link = link_of(element)
        return self._by_id.get(link[1:]) if link.startswith("#") else None

    def ink(self, style: Style, role: str) -> Ink | None:
        """Return the paint of a fill or a stroke; None if nothing is painted.

        Raises:
            SvgError: it is not one colour.
        """
        paint = style[role]
        referred = isinstance(paint, Reference)
        ink = self._even_paint(paint, role) if referred else style.colour(role)
        alpha = ink.alpha * style[f"{role}-opacity"]
        return Ink(ink.grey, alpha) if alpha > 0 else None

    def _even_paint(self, paint: Reference, role: str) -> Ink:
        """Return the paint of a gradient that has one colour, as Inkscape keeps its swatches."""
        if paint.id not in self._by_id and paint.fallback:
            spare = NOTHING if paint.fallback == "none" else colour(paint.fallback)
            if isinstance(spare, Ink):
                return spare
        target = self.referred(role, paint)
        for _ in range(8):  # a gradient may take its stops from another
            stops = [child for child in target if local_name(child)[1] == "stop"]
            further = self.linked(target)
            if stops or further is None:
                break
            target = further
        inks = {self._stop(stop) for stop in stops}
        if len(inks) == 1 and local_name(target)[1].endswith("Gradient"):
            return inks.pop()
        raise SvgError(
            f"{role} is {shown(f'url(#{paint.id})')}, which is not one colour; valid are none, "
            "#rrggbb, rgb(r, g, b) or a name"
        )

    def _stop(self, element: Element) -> Ink:
        style = self.own_style(element)
        ink = style.colour("stop-color")
        return Ink(ink.grey, ink.alpha * style["stop-opacity"])

    def refuse_effect(self, style: Style, name: str) -> None:
        """Refuse a mask, a filter or a marker.

        Raises:
            SvgError: the style has it.
        """
        value = style[name]
        if isinstance(value, Reference):
            raise SvgError(
                f"{name} is {shown(f'url(#{value.id})')}; valid is none: turn what it makes into "
                "paths"
            )


def link_of(element: Element) -> str:
    """Return what an element's link says; empty if it has none."""
    return element.get("href", element.get(LINK, ""))


def pen(style: Style, view: Viewport) -> Pen:
    """Return how a style's strokes are drawn."""

    def units(written: Length) -> float:
        return view.units("stroke-width", written)

    return Pen(
        width=units(style["stroke-width"]),
        cap=style["stroke-linecap"],
        join=style["stroke-linejoin"],
        miter_limit=style["stroke-miterlimit"],
        dashes=tuple(map(units, style["stroke-dasharray"])),
        dash_offset=units(style["stroke-dashoffset"]),
    )
