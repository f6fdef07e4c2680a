"""Routes of the field, and of the filter's parameters."""

from __future__ import annotations

import cv2
from fastapi import APIRouter, Response

from app.engine.program import Program
from app.messages.answers import FieldMessage, FieldsMessage, ParameterMessage, content
from app.page.compressed_route import CompressedRoute
from app.page.parameters import parameter_messages
from app.page.shown_floor import shown_floor
from app.page.telemetry import field_message
from app.settings.field_names import listed_fields


def field_router(program: Program) -> APIRouter:
    """Serve the field and the parameters."""
    router = APIRouter(route_class=CompressedRoute)
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

    return router
