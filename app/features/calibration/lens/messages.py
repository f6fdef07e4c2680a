"""Messages of the lens's calibration on the page: ``/api/lens``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from app.messages.message import Message

Pixels = list[tuple[float, float]]
"""Places in the picture (u, v) [px]."""


class BoardMessage(Message):
    """A printed board."""

    kind: str = "chessboard"
    """chessboard, charuco or aprilgrid."""
    columns: int = 10
    """Squares, or tags, across the page."""
    rows: int = 7
    """Squares, or tags, up the page."""
    square: float = 0.025
    """Side of a square, or of a tag [m]."""
    marker: float = 0.7
    """Side of a marker, as a share of the square's (charuco)."""
    dictionary: str = "5x5_250"
    """Which markers (charuco, aprilgrid)."""
    spacing: float = 0.3
    """Gap between tags, as a share of a tag's side (aprilgrid)."""


class LensStartRequest(Message):
    """Search for this board, and forget the pictures so far."""

    type: Literal["start"]
    board: BoardMessage


class LensCalibrateRequest(Message):
    """Calibrate the lens by the pictures so far."""

    type: Literal["calibrate"]


class LensSaveRequest(Message):
    """Put the lens into the real robot's profile."""

    type: Literal["save"]


LensRequest = Annotated[
    LensStartRequest | LensCalibrateRequest | LensSaveRequest, Field(discriminator="type")
]
LENS_REQUEST: TypeAdapter[LensStartRequest | LensCalibrateRequest | LensSaveRequest] = TypeAdapter(
    LensRequest
)


class LensLookMessage(Message):
    """What was found in the newest picture that was looked at."""

    stamp: float
    """Stamp of its exposure [s]."""
    corners: Pixels
    """The board's corners; empty if it was not found."""
    verdict: Literal["taken", "moving", "known", "refused"]
    """Whether the picture counts, and if not: the board moves, there is one like it, or it is
    useless."""
    words: str
    """Why it does not count; empty if it does."""


class LensBarsMessage(Message):
    """How much of each kind of picture there is, 0 to 1; all are 1 when nothing is missing."""

    x: float
    y: float
    size: float
    tilt: float


class LensStatusMessage(Message):
    """Progress of a calibration, by the WebSocket ``/api/lens``, which takes the requests as well.

    It is sent after each picture to all clients that may drive.
    """

    type: Literal["lens"] = "lens"
    board: BoardMessage | None
    """The board that is searched for; null before the start."""
    look: LensLookMessage | None
    taken: int
    """How many pictures count."""
    least: int
    """How many are needed."""
    outlines: list[Pixels]
    """Outline of the board in each picture that counts."""
    parts: list[list[bool]]
    """Whether enough corners were seen in each part of the picture, row by row from the top."""
    bars: LensBarsMessage
    next_steps: list[str]
    """What to do next with the board, the most useful first; empty if nothing is missing."""
    busy: bool
    """Whether the calibration is being computed."""
    problem: str
    """Why the last request failed; empty if it did not."""
    calibrations: int
    """How many lenses were calibrated; ``/api/lens`` has the newest."""
    profile: str | None
    """The file that a save writes; null without a real robot."""
    saved: bool
    """Whether the newest lens is in it."""


class LensRatingMessage(Message):
    """How well a model of lenses fits."""

    model: str
    held_out_px: float | None
    """Root mean square error in pictures that were held out [px]; null if it failed there."""
    own_px: float
    """The same in the pictures that it was fitted to: the reprojection error [px]."""


class LensParameterMessage(Message):
    """One number of the lens."""

    name: str
    value: float
    interval: float
    """Half of the 95 % interval."""


class LensRefusalMessage(Message):
    """A picture that was taken and does not count after all."""

    picture: str
    reason: str


class LensMessage(Message):
    """A lens that was calibrated."""

    model: str
    width: int
    height: int
    """Size of the pictures [px]."""
    pictures: int
    board: str
    """The board that it was calibrated by, in words."""
    ratings: list[LensRatingMessage]
    """How well each model fits."""
    parameters: list[LensParameterMessage]
    corners: Pixels
    errors: Pixels
    """Distance of each corner from where the lens projects it [px]."""
    outlines: list[Pixels]
    refused: list[LensRefusalMessage]
    missing: list[str]
    """What more pictures should show; empty if nothing."""


MESSAGES = (
    LensStatusMessage,
    LensMessage,
    LensStartRequest,
    LensCalibrateRequest,
    LensSaveRequest,
)
