"""Routes of the field, the filter's parameters, and what the scanner saw."""

from __future__ import annotations

import cv2
from fastapi import APIRouter, HTTPException, Response

from app.engine.program import Program
from app.messages.answers import (
    FieldMessage,
    FieldsMessage,
    ParameterMessage,
    ProfileMessage,
    content,
    refusal,
)
from app.page.parameters import parameter_messages
from app.page.profile import RayError, profile
from app.page.shown_floor import shown_floor
from app.page.telemetry import field_message
from app.settings.field_names import listed_fields

NO_PICTURE = refusal(503, "before the camera's first picture")


def field_router(program: Program) -> APIRouter:
    """Serve the field, the parameters, and what the scanner saw along a ray."""
    router = APIRouter()
    smallest = (cv2.IMWRITE_PNG_COMPRESSION, 9)  # a third of the usual size
    _, picture = cv2.imencode(".png", shown_floor(program.field), smallest)
    png = picture.tobytes()

    @router.get("/api/field")
    def get_field() -> FieldMessage:
        """The field, and what is known of the robot."""
        return field_message(program)

    @router.get("/api/field.png", response_class=Response, responses=content("image/png"))
    def field_picture() -> Response:
        """The floor from above."""
        return Response(png, media_type="image/png", headers={"Cache-Control": "no-cache"})

    @router.get("/api/fields")
    def fields() -> FieldsMessage:
        """The fields that can be loaded, and the saved maps; of generated ones, an example."""
        return FieldsMessage(names=listed_fields(program.config.mapping.path()))

    @router.get("/api/parameters")
    def parameters() -> list[ParameterMessage]:
        """The filter's parameters, with their meanings."""
        latest = program.engine.latest.get()
        configured = program.config.localization
        given = program.given
        if latest is None:
            return parameter_messages(configured, configured, given, given)
        return parameter_messages(latest.filter.parameters, configured, latest.filter.models, given)

    @router.get("/api/ray/{ray}", responses=NO_PICTURE | refusal(404, "no such ray"))
    def ray_profile(ray: int) -> ProfileMessage:
        """What the scanner saw along one ray of the newest picture, and why it counted or not."""
        program.engine.audience.visit()
        latest = program.engine.latest.get()
        if latest is None or latest.filter.line_scan is None or latest.filter.scanner is None:
            raise HTTPException(503, "The camera has sent no picture yet.")
        try:
            return profile(latest.filter.scanner, latest.filter.line_scan, ray)
        except RayError as error:
            raise HTTPException(404, str(error)) from error

    return router
