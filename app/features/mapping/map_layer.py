"""The map that is drawn by driving, in the 3D view: tape, edges, pose graph and corrections."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser

from app.page.view.marks import lifted
from robot.geometry import Array
from robot.mapping.sketch import Sketch

TAPE, BAND, EDGES, GRAPH, CORRECTION = (
    (176, 16, 107),
    (222, 150, 190),
    (168, 98, 0),
    (10, 72, 168),
    (140, 60, 170),
)
HEIGHT = {"edges": 0.003, "band": 0.004, "tape": 0.005, "graph": 0.006, "correction": 0.007}
"""Heights above the floor [m]; they differ, so that layers do not flicker through each other."""
INTERVAL = 1.96
"""Half a 95 % interval, in standard deviations."""
LEAST_CORRECTION = 0.002
"""Poses that were moved by less in the last adjustment are not marked [m]."""


class MapLayer:
    """Shows the newest sketch of the map, in the frame of its map."""

    def __init__(self, scene: viser.SceneApi, sketch: Callable[[], Sketch | None]) -> None:
        """Show what a function returns; None hides everything."""
        self._sketch = sketch
        self._shown: Sketch | None = None
        line, point = np.zeros((1, 2, 3)), np.zeros((1, 3), np.float32)
        self._lines = {
            name: scene.add_line_segments(
                f"/mapping/{name}",
                line,
                colour,
                thickness=width,
                thickness_units="world",
                visible=False,
            )
            for name, colour, width in (
                ("tape", TAPE, 0.006),
                ("band", BAND, 0.002),
                ("graph", GRAPH, 0.002),
                ("correction", CORRECTION, 0.003),
            )
        }
        self._points = {
            name: scene.add_point_cloud(
                f"/mapping/{name}_points",
                point,
                colour,
                point_size=size,
                point_shape="circle",
                point_shading="flat",
                visible=False,
            )
            for name, colour, size in (("edges", EDGES, 0.004), ("graph", GRAPH, 0.006))
        }

    def update(self) -> None:
        """Show the map as it is now, if it has changed."""
        sketch, before = self._sketch(), self._shown
        if sketch is before:
            return
        self._shown = sketch
        if sketch is None:
            for node in (*self._lines.values(), *self._points.values()):
                node.visible = False
            return
        places = sketch.path[:, :2]
        self._show_lines("tape", _segments(sketch.lines))
        self._show_lines("band", _segments(_bands(sketch)))
        self._show_lines("graph", _segments([places]))
        self._show_lines("correction", _corrections(before, places))
        for name, points in (("edges", sketch.edges), ("graph", places)):
            self._points[name].points = lifted(points, HEIGHT[name]).astype(np.float32)
            self._points[name].visible = len(points) > 0

    def _show_lines(self, name: str, segments: Array) -> None:
        node = self._lines[name]
        node.visible = len(segments) > 0
        if len(segments):  # viser does not redraw empty nodes
            node.points = lifted(segments, HEIGHT[name]).astype(np.float32)


def _segments(lines: tuple[Array, ...] | list[Array]) -> Array:
    """Return the segments (n, 2, 2) of lines, each (m, 2) [m]."""
    parts = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
    return np.concatenate(parts) if parts else np.zeros((0, 2, 2))


def _bands(sketch: Sketch) -> list[Array]:
    """Return both borders of each line's 95 % interval, where it is widest."""
    borders = []
    for line, sd in zip(sketch.lines, sketch.sd, strict=True):
        along = np.gradient(line, axis=0)
        left = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
        borders += [line + INTERVAL * sd * left, line - INTERVAL * sd * left]
    return borders


def _corrections(before: Sketch | None, places: Array) -> Array:
    """Return from where to where poses were moved by the last adjustment (n, 2, 2) [m]."""
    earlier = np.zeros((0, 2)) if before is None else before.path[:, :2]
    count = min(len(earlier), len(places))
    moved = np.stack([earlier[:count], places[:count]], axis=1)
    way = moved[:, 1] - moved[:, 0]
    corrected: Array = moved[np.hypot(way[:, 0], way[:, 1]) > LEAST_CORRECTION]
    return corrected
