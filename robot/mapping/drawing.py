"""Writes strokes as an SVG drawing, as the fields in ``maps/`` are."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from robot.fields.unseen_floor import SEEN
from robot.geometry import Array
from robot.mapping.joining import EndName
from robot.mapping.strokes import Stroke
from robot.mapping.tidying import TidyStrokes

MARGIN_MM = 250
"""Floor around the tape, and around where the robot was [mm]."""
DARK, LIGHT = "#202225", "#f2f1ec"
"""Colours of tape that is darker, and lighter, than the floor."""
FLOORS = {(False,): "#d7d5cf", (True,): "#3a3c40", (False, True): "#6e6e6b"}
"""Colour of the floor by the tape that is on it: dark, light, or both. A field takes a stroke for
tape only if it differs that much from the floor (``drawn_tape``)."""


def drawing(
    tidy: TidyStrokes,
    width: float,
    path: Array,
    title: str,
    seen: Sequence[Array] = (),
    statements: Sequence[str] = (),
    fit: str = "",
) -> str:
    """Return the text of an SVG, in millimetres.

    Args:
        tidy: the strokes [m].
        width: of the tape [m].
        path: (k, 3) where the robot was, in the map [m, m, rad]; all of it is on the floor, and
            it starts at the first.
        title: for people.
        seen: outlines (n, 2) of the floor that was looked at [m]; all of it if there is none.
        statements: what is said of the map, for people.
        fit: the same as data, in JSON (``FitQuality.table``).
    """
    points = 1e3 * np.vstack([path[:, :2], *(stroke.points for stroke in tidy.strokes)])
    low, high = np.floor(points.min(axis=0)) - MARGIN_MM, np.ceil(points.max(axis=0)) + MARGIN_MM
    # SVG's y points down.
    left, top, across, down = low[0], -high[1], high[0] - low[0], high[1] - low[1]
    x, y, theta = path[0].tolist()
    begin = f"{1e3 * x:g} {1e3 * y:g} {np.degrees(theta):g}"
    shades = tuple(sorted({stroke.light for stroke in tidy.strokes}))
    looked = f' {SEEN}="{"; ".join(map(_outline, seen))}"' if seen else ""
    words = escape("; ".join(statements))
    about = f"\n  <desc data-fit={quoteattr(fit)}>{words}</desc>" if statements else ""
    groups = "\n".join(_group(tidy, light, width) for light in shades)
    return f"""\
<svg xmlns="http://www.w3.org/2000/svg" width="{across:g}mm" height="{down:g}mm" \
viewBox="{left:g} {top:g} {across:g} {down:g}" data-start="{begin}" \
data-tape="{1e3 * width:g}"{looked}>
  <title>{escape(title)}</title>{about}
  <rect x="{left:g}" y="{top:g}" width="{across:g}" height="{down:g}" fill="{FLOORS[shades]}"/>
  <!-- Inside, y points up as it does in the map. -->
{groups}
</svg>
"""


def _group(tidy: TidyStrokes, light: bool, width: float) -> str:
    """Return the strokes that are light, or dark, as an SVG group."""
    paths = "\n".join(f'    <path d="{path}"/>' for path in _paths(tidy, light))
    return f"""\
  <g transform="scale(1 -1)" fill="none" stroke="{LIGHT if light else DARK}" \
stroke-width="{1e3 * width:g}" stroke-miterlimit="10">
{paths}
  </g>"""


def _paths(tidy: TidyStrokes, light: bool) -> list[str]:
    """Return strokes of one shade as SVG paths; those that meet in corners are one path."""
    left = {number for number, stroke in enumerate(tidy.strokes) if stroke.light == light}
    follower = {}
    for a, b in tidy.corners:
        if a[0] in left and b[0] in left:
            follower[a], follower[b] = b, a
    paths = []
    # Chains with an open end first: what is left then are rings.
    starts: list[EndName] = [
        (number, last)
        for number in sorted(left)
        for last in (False, True)
        if (number, last) not in follower
    ]
    for number, last in [*starts, *((number, False) for number in sorted(left))]:
        if number not in left:
            continue
        chain: list[Stroke] = []
        end: EndName | None = (number, last)
        while end is not None and end[0] in left:
            left.remove(end[0])
            stroke = tidy.strokes[end[0]]
            chain.append(stroke.reversed if end[1] else stroke)
            end = follower.get((end[0], not end[1]))
        paths.append(_path(chain, ring=end is not None))
    return paths


def _path(chain: Sequence[Stroke], ring: bool) -> str:
    parts = [f"M {_shown(chain[0].nodes[0])}"]
    for index, stroke in enumerate(chain):
        if stroke.curved:
            parts.append(_curve(stroke))
        elif not ring or index < len(chain) - 1:
            parts.append(f"L {_shown(stroke.nodes[1])}")
    if ring or chain[0].closed:
        parts.append("Z")
    return " ".join(parts)


def _curve(stroke: Stroke) -> str:
    """Return a spline as Bezier curves: each of its spans is one."""
    spline, knots = stroke.spline(stroke.nodes), stroke.knots
    places, slopes = spline(knots), spline(knots, 1)
    third = np.diff(knots)[:, None] / 3
    before, after = places[:-1] + third * slopes[:-1], places[1:] - third * slopes[1:]
    spans = zip(before, after, places[1:], strict=True)
    return "C " + ", ".join(" ".join(_shown(point) for point in span) for span in spans)


def _outline(corners: Array) -> str:
    return " ".join(f"{x:.0f} {y:.0f}" for x, y in 1e3 * corners)


def _shown(point: Array) -> str:
    x, y = np.round(1e3 * point, 2) + 0.0
    return f"{x:g} {y:g}"
