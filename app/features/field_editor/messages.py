"""Messages on fields of one's own: which there are, and what of a drawing can be edited."""

from __future__ import annotations

from app.messages.message import Message


class FieldEntry(Message):
    """A field that can be chosen."""

    name: str
    own: bool
    """Whether it is a file of the user's, which can be deleted."""
    drawing: bool
    """Whether it is a drawing, which can be edited and printed; others have a picture only."""
    changed: float
    """When its file was written [s since 1970]; 0 where there is none."""


class KeptFieldMessage(Message):
    """A file that was kept among the user's fields."""

    name: str
    remarks: list[str]
    """What of the file is no part of the field, in words."""


class EditableStrokeMessage(Message):
    """A strip of tape, of straight lines and arcs."""

    nodes: list[tuple[float, float, float]]
    """x, y [mm] in the map frame, and how far the tape bends on its way to the next node: the
    tangent of a quarter of the arc's angle, positive if it turns left; 0 is straight."""
    closed: bool
    width: float
    """[mm]"""
    grey: int
    """Brightness, 0 to 255."""
    dashes: list[float]
    """Lengths of dash, gap, ... [mm]; empty if it has none."""


class EditableFillMessage(Message):
    """An area of another tone, which the editor keeps as it is."""

    rings: list[list[tuple[float, float]]]
    """Its outlines, x and y [mm] in the map frame: what lies within an odd number is filled."""
    grey: int
    opacity: float


class EditableDrawingMessage(Message):
    """A drawing as the editor takes it; lengths in mm, y up, as in the map."""

    left: float
    bottom: float
    width: float
    height: float
    start: tuple[float, float, float]
    """x, y [mm] and heading [degrees] of the robot."""
    strokes: list[EditableStrokeMessage]
    fills: list[EditableFillMessage]
    """In the order of painting, below all strokes."""
    kept: dict[str, str]
    """Other ``data-`` attributes of the drawing."""
    remarks: list[str]
    """What is not as in the drawing, in words."""


MESSAGES = (FieldEntry, KeptFieldMessage, EditableDrawingMessage)
