"""What one tick shows."""

from __future__ import annotations

from typing import Literal

from app.messages.message import Layer, Message
from robot.localization.integrity import State


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
    """One place where the robot may be, carried forward to the telemetry's stamp."""

    weight: float
    """How likely it is, 0 to 1."""
    covariance: list[float]
    """9 numbers by rows [m^2, m rad, rad^2]."""


class ParticlesMessage(Message):
    """The cloud."""

    count: int
    effective: float
    """Effective sample size, 1 to count."""
    hypotheses: list[HypothesisMessage]
    """Where the robot may be, heaviest first; none while nothing can be said."""
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
    broken: str | None
    """What is wrong with a model in a file of the user's own, with file and line; the robot stands
    still and the filter pauses until it is mended."""


class IntegrityMessage(Message):
    """What is claimed of the estimate."""

    state: State
    """certain: one place within a narrow bound; approximate: one, within a wide bound; ambiguous:
    several places look alike; searching: no place stands out; lost: one did that fits no more."""
    radius: float | None
    """The robot is within this distance of the estimate [m], in 99.9 % of pictures; null where
    nothing is claimed."""
    heading_bound: float | None
    """Its heading is within this angle of the estimate's [rad]; null where nothing is claimed."""
    alerts: list[str]
    """Reasons for doubt in plain words, the likeliest first; empty when there is none."""


class RecordingMessage(Message):
    """What is being recorded, or was until it ended by itself."""

    file: str
    """Its name; ``/api/recordings`` has it."""
    running: bool
    duration_s: float
    size_bytes: int
    message: str | None
    """Why it ended by itself, or what is missing in it; null when all is well."""


class ReplayMessage(Message):
    """Where in a recording the program is."""

    file: str
    position_s: float
    """Since its beginning."""
    duration_s: float
    speed: float
    """Seconds of the recording a second."""
    paused: bool
    catching_up: float | None
    """How far it is on its way to a place that was asked for, 0 to 1; null when it is there."""
    estimate_then: PoseMessage | None
    """What was estimated when it was recorded."""


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
    integrity: IntegrityMessage
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
    recording: RecordingMessage | None = None
    replay: ReplayMessage | None = None
    """Null with a robot that is there now."""
    hidden_layers: list[Layer] | None = None
    """Layers of the 3D view that are switched off, for all viewers; null where there is none."""
