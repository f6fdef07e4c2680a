"""What the page asks about the map that is drawn by driving."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from fastapi import APIRouter, HTTPException, Response

from app.engine.snapshot import Snapshot
from app.features.calibration.routes import INTERVAL
from app.features.mapping.drawing import MapDrawing
from app.features.mapping.map_drawer import MapDrawer
from app.features.mapping.messages import MapDrawingMessage, StrokeMessage
from app.messages.answers import content, refusal
from app.messages.telemetry import MappingMessage, PoseMessage
from robot.geometry import Array
from robot.mapping.sketch import Sketch, largest_by_stroke
from robot.mapping.tape_map import TapeMap

Points = list[tuple[float, float]]


def mapping_message(drawing: MapDrawing | None, snapshot: Snapshot) -> MappingMessage | None:
    """Return how far a map is at a tick; None without one."""
    if drawing is None:
        return None
    pose = None
    if drawing.map_from_odom is not None:
        place = drawing.map_from_odom @ snapshot.odom_from_robot
        pose = PoseMessage(x=place.x, y=place.y, theta=place.theta)
    return MappingMessage(
        state=drawing.state,
        seconds=drawing.seconds,
        paused=drawing.paused,
        version=drawing.version,
        pose=pose,
        message=drawing.words,
    )


def mapping_router(drawer: MapDrawer) -> APIRouter:
    """Return the routes that show the map."""
    router = APIRouter()

    @router.get("/api/mapping")
    def mapping() -> MapDrawingMessage:
        """The map that is drawn by driving, as far as it is."""
        return drawing_message(drawer.drawing)

    @router.get(
        "/api/mapping.svg",
        response_class=Response,
        responses=content("image/svg+xml") | refusal(404, "before a map is finished"),
    )
    def drawing_file() -> Response:
        """The finished map as a drawing; `brickpose run --map` takes it."""
        drawing = drawer.drawing
        if drawing is None or drawing.result is None:
            raise HTTPException(404, "There is no finished map.")
        return Response(
            drawing.result.drawing("Drawn by driving"),
            media_type="image/svg+xml",
            headers={"Content-Disposition": 'attachment; filename="field.svg"'},
        )

    return router


def sketch_of(drawer: MapDrawer) -> Sketch | None:
    """Return the map that is drawn, as far as it is; None without one."""
    drawing = drawer.drawing
    return None if drawing is None else drawing.sketch


def drawing_message(drawing: MapDrawing | None) -> MapDrawingMessage:
    """Return a map as far as it is drawn."""
    if drawing is not None and drawing.result is not None:
        return _finished(drawing.result, drawing)
    sketch = None if drawing is None else drawing.sketch
    if drawing is None or sketch is None:
        return MapDrawingMessage(
            version=0,
            strokes=[],
            path=[],
            edges=[],
            unseen_ends=[],
            facts=[],
            remarks=[],
            changes=0,
        )
    return MapDrawingMessage(
        version=drawing.version,
        strokes=_strokes(sketch.lines, sketch.sd),
        path=_points(sketch.path[:, :2]),
        edges=_points(sketch.edges),
        unseen_ends=[],
        facts=[],
        remarks=[],
        changes=0,
    )


def _finished(drawn: TapeMap, drawing: MapDrawing) -> MapDrawingMessage:
    # What is tidy has other strokes than what was measured: the nearest one tells how certain.
    measured = largest_by_stroke(drawn.measured.each, drawn.node_sd)
    middles = np.array([stroke.points.mean(axis=0) for stroke in drawn.measured.each])
    lines = [stroke.points for stroke in drawn.tidy.strokes]
    nearest = [np.hypot(*(middles - line.mean(axis=0)).T).argmin() for line in lines]
    return MapDrawingMessage(
        version=drawing.version,
        strokes=_strokes(lines, measured[nearest]),
        path=_points(drawn.solution.state.poses[:, :2]),
        edges=[] if drawing.sketch is None else _points(drawing.sketch.edges),
        unseen_ends=_points(drawn.unseen_ends),
        facts=list(drawn.facts),
        remarks=list(drawn.remarks),
        changes=len(drawing.earlier),
        contradictory=bool(drawn.quality.contradictions),
    )


def _strokes(lines: Iterable[Array], sd: Array) -> list[StrokeMessage]:
    return [
        StrokeMessage(points=_points(line), interval=INTERVAL * spread)
        for line, spread in zip(lines, sd.tolist(), strict=True)
    ]


def _points(points: Array) -> Points:
    return [(x, y) for x, y in points.round(4).tolist()]
