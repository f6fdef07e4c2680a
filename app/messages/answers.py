"""Messages that answer HTTP requests, and how ``/openapi.json`` describes refusals and files."""

from __future__ import annotations

from typing import Any, Literal

from app.messages.message import Message
from app.messages.telemetry import PoseMessage

Responses = dict[int | str, dict[str, Any]]
"""By status, as FastAPI wants it."""


class CompilingMessage(Message):
    """How far the first start is, which compiles functions for this computer."""

    done: int
    """Functions that are compiled."""
    total: int
    """Functions that are to be compiled, those included."""


class HealthMessage(Message):
    """Whether the program works."""

    status: Literal["ok", "degraded", "failed"]
    detail: str
    robot: str
    uptime_s: float
    step_hz: float
    compiling: CompilingMessage | None = None
    """Present while functions are compiled; there is no robot before that is done."""


class AccessMessage(Message):
    """What the token of a request allows."""

    role: Literal["drive", "watch"]
    why: str = ""
    """Why it only watches, in words, if that is not what its token says."""


class LanguageMessage(Message):
    """The texts of one language."""

    language: str
    """Its code, as ``de``."""
    plural: str
    """Which form a number n takes: an expression in C, as gettext has it."""
    point: str
    """Between a number's whole part and its decimals."""
    texts: dict[str, list[str]]
    """By English text: one form, or each plural's; places for values are ``{names}``."""


class FieldMessage(Message):
    """The field, the robot on it, and limits: a page needs them once, and again after a
    calibration."""

    name: str
    drive_area: list[float]
    """xmin, ymin, xmax, ymax [m] of the free part, where robots drive."""
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] of ``/api/field.png``."""
    view_home: tuple[float, float, float]
    """Where the camera of the 3D view begins [m]; it looks at the middle of ``extent``."""
    start: PoseMessage
    robot_outline: list[tuple[float, float]]
    """The robot's outline on the floor [m], in the robot frame."""
    robot_measured: str
    """When and by what the robot was calibrated; empty if it is as described."""
    engine_missing: bool
    """Whether a simulated robot moves without forces, and no physics engine is installed here."""
    max_v: float
    max_omega: float
    drive_timeout: float
    """How long a drive command holds if it is not renewed [s]."""
    stale_after: float
    """Telemetry older than this [s] does not show the present."""
    longest_step: float
    """A longer step between two messages of telemetry [m] was not driven: something was put
    elsewhere."""
    initial_sd_xy: float
    initial_sd_theta: float
    """Configured spread of a pose that is set without a spread [m, rad]."""
    image_width: int
    image_height: int
    """Size of the camera's picture [px]."""
    tape_width: float
    """Width of tape that the scanner looks for [m], to compare with ``ScanMessage.tape_width``."""
    rays_px: list[list[tuple[float, float]]]
    """Each ray as a line of pixels, from its start to its end in the picture."""
    features: list[str]
    """Names of the features that take part; the page hides what belongs to others."""


class ViewCameraMessage(Message):
    """The camera of a page's 3D view, in the map."""

    position: tuple[float, float, float]
    wxyz: tuple[float, float, float, float]
    """How it is turned: its x points right, its y down, and its z ahead."""
    fov: float
    """The angle that it sees from top to bottom [rad]."""


class ParameterMessage(Message):
    """One parameter of the filter, with its meaning."""

    name: str
    group: Literal["motion", "sensor", "filter", "hypotheses", "faults"]
    value: float | str | bool
    default: float | str | bool
    meaning: str
    unit: str
    low: float | None
    high: float | None
    choices: list[str]
    integer: bool = False
    """Whether only whole numbers are valid."""
    used: bool = True
    """Whether the chosen filter and models use it."""


class FieldsMessage(Message):
    """The fields that the page can load."""

    names: list[str]


class ProblemMessage(Message):
    """One entry of the record of problems."""

    stamp: float
    message: str


class ProblemsMessage(Message):
    """The record of problems, newest last; at most the last hundred."""

    problems: list[ProblemMessage]
    trace: str = ""
    """The calls that led to the current fault of a user's own model, with their lines."""


class RefusalMessage(Message):
    """Why a request cannot be answered."""

    detail: str


def refusal(status: int, words: str) -> Responses:
    """Describe a status that refuses a request, and when it does."""
    return {status: {"model": RefusalMessage, "description": words}}


def content(media_type: str) -> Responses:
    """Describe an answer that is no JSON."""
    return {200: {"content": {media_type: {"schema": {"type": "string", "format": "binary"}}}}}
