"""What crosses the wire: telemetry out, commands in; told apart by ``type``.

Metres, seconds and radians; the map frame unless said otherwise; theta from +x, anticlockwise.
Unknown keys, NaN and infinities are refused. ``frontend/messages.d.ts`` is made from this file by
``python -m app.typescript``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

Layer = Literal["particles", "headings", "rays", "covariance", "paths", "truth"]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Radians = Annotated[float, Field(ge=-1e3, le=1e3)]


class Message(BaseModel):
    """What all messages share: frozen, finite, and no key that is not listed."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


# --- telemetry -------------------------------------------------------------------------------


class PoseMessage(Message):
    """A pose in the map [m, m, rad]."""

    x: float
    y: float
    theta: float


class EstimateMessage(PoseMessage):
    """Where the filter believes the robot is, carried forward to the telemetry's stamp."""

    covariance: list[float]
    """9 numbers by rows [m^2, m rad, rad^2]."""


class TwistMessage(Message):
    """A velocity [m/s, rad/s], as applied after limits."""

    v: float
    omega: float


class HypothesisMessage(PoseMessage):
    """One cluster of particles."""

    weight: float


class ParticlesMessage(Message):
    """The cloud."""

    count: int
    effective: float
    """Effective sample size, 1 to count."""
    hypotheses: list[HypothesisMessage]
    """Clusters, heaviest first; at most eight."""
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] that the bytes of ``cloud`` span."""
    cloud: str
    """base64 of 8 bytes a particle, little-endian: uint16 x, uint16 y over the extent (0 to 65535),
    int16 theta (pi is 32768), uint8 weight (255 is the heaviest), uint8 zero. At most 2,000."""


class ScanMessage(Message):
    """The newest scan, and where it was found in the picture."""

    stamp: float
    """Exposure of the frame it comes from [s]."""
    bearings: list[float]
    ranges: list[float | None]
    """[m]; no return is null."""
    robot_from_scan: PoseMessage
    """Where the rays start, in the robot frame."""
    robot: PoseMessage | None
    """The estimate at the scan's stamp, to draw the scan from."""
    entry_px: list[tuple[float, float] | None]
    """Pixel (u, v) where the ray enters the tape, a ray each; null where none counted."""
    exit_px: list[tuple[float, float] | None]
    tape_width: float | None
    """Median width measured over the rays that counted [m]."""


class RobotMessage(Message):
    """The robot itself."""

    name: str
    connected: bool
    battery_v: float | None
    can_be_placed: bool


class LoopMessage(Message):
    """How the engine keeps up."""

    step_hz: float
    step_ms: float
    """Work of one step, smoothed."""
    frame_hz: float
    latency_ms: float
    """From the exposure of the newest frame to this telemetry, on the robot's clock."""


class FilterMessage(Message):
    """What the filter does."""

    paused: bool
    updates: int
    """Measurement updates since the last set_pose, scatter or reset."""
    ambiguous: bool
    """Whether a second hypothesis has at least a fifth of the weight."""


class TelemetryMessage(Message):
    """Everything that one tick shows."""

    type: Literal["telemetry"] = "telemetry"
    stamp: float
    """The robot's clock [s]."""
    map: str
    truth: PoseMessage | None
    odometry: PoseMessage | None
    """Dead reckoning since the start (or the last place), in the map."""
    estimate: EstimateMessage | None
    twist: TwistMessage
    mode: Literal["idle", "drive", "figure_eight"]
    particles: ParticlesMessage
    scan: ScanMessage
    robot: RobotMessage
    loop: LoopMessage
    filter: FilterMessage
    problems: list[str]
    """What is wrong now, in plain words; empty when all is well."""
    error_count: int
    """Problems since the start; ``/api/problems`` lists them."""
    hidden_layers: list[Layer] | None = None
    """Layers of the 3D view that are switched off, for all viewers; null where there is none."""


# --- commands --------------------------------------------------------------------------------


class CommandMessage(Message):
    """What all commands share; a number must be one, not a text or a truth value that could be."""

    model_config = ConfigDict(strict=True)

    id: int | str | None = None
    """Repeated in the answer."""


class DriveCommand(CommandMessage):
    """Drive; holds for 0.5 s, so it is renewed. Beyond the limits it is limited."""

    type: Literal["drive"]
    v: Annotated[float, Field(ge=-10, le=10)]
    omega: Annotated[float, Field(ge=-100, le=100)]


class StopCommand(CommandMessage):
    """Stand still at once, whatever drives."""

    type: Literal["stop"]


class FigureEightCommand(CommandMessage):
    """Drive the open-loop figure-eight; holds for 0.5 s like drive, and goes on when renewed."""

    type: Literal["figure_eight"]


class SetPoseCommand(CommandMessage):
    """Tell the filter where the robot is, and how sure that is."""

    type: Literal["set_pose"]
    x: Metres
    y: Metres
    theta: Radians
    sd_xy: Annotated[float, Field(gt=0, le=100)] | None = None
    sd_theta: Annotated[float, Field(gt=0, le=10)] | None = None


class ScatterCommand(CommandMessage):
    """Spread the cloud over the whole field: the robot may be anywhere."""

    type: Literal["scatter"]


class PlaceCommand(CommandMessage):
    """Put the simulated robot itself elsewhere; the filter is not told."""

    type: Literal["place"]
    x: Metres
    y: Metres
    theta: Radians


class PauseCommand(CommandMessage):
    """Stop updating the filter by measurements; odometry goes on moving the cloud."""

    type: Literal["pause"]


class ResumeCommand(CommandMessage):
    """Update the filter again."""

    type: Literal["resume"]


class UpdateCommand(CommandMessage):
    """One measurement update with the next frame, even paused or standing still."""

    type: Literal["update"]


class ResetCommand(CommandMessage):
    """The filter's parameters as configured at the start, and the cloud at the start pose."""

    type: Literal["reset"]


class SetParametersCommand(CommandMessage):
    """Change parameters of the filter; all or none, names as ``/api/parameters`` lists them."""

    type: Literal["set_parameters"]
    values: Annotated[dict[str, float | str | bool], Field(min_length=1, max_length=64)]


class ShowCommand(CommandMessage):
    """Switch a layer of the 3D view on or off; all viewers share that view."""

    type: Literal["show"]
    layer: Layer
    visible: bool


class PingCommand(CommandMessage):
    """Do nothing; the answer's stamp lines up the clocks."""

    type: Literal["ping"]


Command = Annotated[
    DriveCommand
    | StopCommand
    | FigureEightCommand
    | SetPoseCommand
    | ScatterCommand
    | PlaceCommand
    | PauseCommand
    | ResumeCommand
    | UpdateCommand
    | ResetCommand
    | SetParametersCommand
    | ShowCommand
    | PingCommand,
    Field(discriminator="type"),
]
COMMAND: TypeAdapter[Command] = TypeAdapter(Command)


class AckMessage(Message):
    """The command was taken."""

    type: Literal["ack"] = "ack"
    id: int | str | None
    stamp: float | None
    """The robot's clock when the answer was written, to line up the clocks [s]."""


class ErrorMessage(Message):
    """The command was refused, and why."""

    type: Literal["error"] = "error"
    id: int | str | None
    message: str


# --- answers over HTTP ---------------------------------------------------------------------------


class HealthMessage(Message):
    """Whether the program does its job."""

    status: Literal["ok", "degraded", "failed"]
    detail: str
    robot: str
    uptime_s: float
    step_hz: float


class FieldMessage(Message):
    """The field and the robot on it: what a map view needs once."""

    name: str
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] of ``/api/field.png``."""
    start: PoseMessage
    robot_outline: list[tuple[float, float]]
    """The robot's outline on the floor [m], in the robot frame."""
    max_v: float
    max_omega: float
    image_width: int
    image_height: int
    """Size of the camera's picture [px]."""
    rays_px: list[list[tuple[float, float]]]
    """Each ray as a line of pixels, from its start to its end in the picture."""


class ParameterMessage(Message):
    """One parameter of the filter, with its meaning."""

    name: str
    group: Literal["motion", "sensor", "filter"]
    value: float | str | bool
    default: float | str | bool
    meaning: str
    unit: str
    low: float | None
    high: float | None
    choices: list[str]
    integer: bool = False
    """Whether only whole numbers are valid."""


class ProfileMessage(Message):
    """What the scanner saw along one ray of the newest frame."""

    stamp: float
    ray: int
    bearing: float
    distances: list[float]
    """Floor distance of each sample from the rays' centre [m]."""
    grey: list[float]
    """Brightness, 0 to 255."""
    response: list[float]
    """Answer of the edge kernel, in grey levels; negative where it gets darker."""
    threshold: float
    entry: float | None
    """Distance of the entry edge [m]."""
    exit: float | None
    width: float | None
    """Measured across the line [m]."""
    counted: bool
    why: str
    """Why it counted or not, in plain words."""


class ProblemMessage(Message):
    """One entry of the record of errors."""

    stamp: float
    message: str


class ProblemsMessage(Message):
    """The record of errors, newest last; at most the last hundred."""

    problems: list[ProblemMessage]


def schema() -> dict[str, Any]:
    """The JSON schema of every message, for the frontend's types."""
    adapters: list[Any] = [
        TelemetryMessage, Command, AckMessage, ErrorMessage, HealthMessage, FieldMessage,
        ParameterMessage, ProfileMessage, ProblemsMessage,
    ]  # fmt: skip
    _, definitions = TypeAdapter.json_schemas(
        [(adapter, "validation", TypeAdapter(adapter)) for adapter in adapters]
    )
    return definitions
