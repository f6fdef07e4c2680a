"""Telemetry: everything that one tick shows, and what is found in a picture."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.messages.message import Layer, Message
from robot.localization.estimate import State


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
    """The cloud of particles, and the hypotheses."""

    count: int
    effective: float
    """Effective sample size, 1 to count."""
    hypotheses: list[HypothesisMessage]
    """Where the robot may be, heaviest first; empty while nothing is known."""
    alike: int
    """How many of them may be the robot's place: 1 if one stands out, more if several look alike, 0
    if none stands out."""
    likely: int
    """How many of them are likely enough to be drawn."""
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] of the area that x and y in ``cloud`` span."""
    cloud: str
    """base64 of 8 bytes per particle, little-endian: uint16 x, uint16 y over the extent (0 to
    65535), int16 theta (pi is 32768), uint8 weight (255 is the heaviest), uint8 zero. At most 2,000
    particles."""


class ScanMessage(Message):
    """The newest scan; ``PictureMessage`` has its edges in the picture."""

    stamp: float
    """Stamp of its picture's exposure [s]."""
    bearings: list[float]
    ranges: list[float | None]
    """Ranges [m]; null means no return."""
    robot_from_scan: PoseMessage
    """Where the rays start, in the robot frame."""
    robot: PoseMessage | None
    """The estimate at the scan's stamp, to draw the scan from."""
    tape_width: float | None
    """Median width measured over the rays that counted [m]."""


class RobotMessage(Message):
    """The robot itself."""

    name: str
    connected: bool
    battery_v: float | None
    can_be_placed: bool
    engine: str | None
    """Name and version of the physics engine that moves a simulated robot; null: none does."""
    faults: dict[str, float | str]
    """Faults of a simulated robot that it did not have at the start, by their names in
    ``/api/faults``."""
    calibrated: float | None
    """The robot's clock at the last calibration since the start [s]; ``/api/field`` changed then.
    Null before the first."""


class LoopMessage(Message):
    """Rates and delays of the engine."""

    step_hz: float
    step_ms: float
    """Work of one step, smoothed."""
    frame_hz: float
    latency_ms: float
    """From the exposure of the newest frame to this telemetry, on the robot's clock."""


class HandMessage(Message):
    """Progress of the filter by hand."""

    number: int
    """Changes with each step, forwards or back; ``/api/filter_by_hand`` has the step."""
    last: Literal["predict", "weigh", "resample"] | None
    """The last step; null before the first."""
    undoable: int
    """How many steps can be taken back."""
    effective: float
    """Effective sample size of the current particles."""
    ahead: PoseMessage
    """How far the wheels have driven since the last prediction, in the robot frame."""


class FilterMessage(Message):
    """State of the filter."""

    paused: bool
    kind: str
    """Its name, one of those of the parameter ``filter``."""
    hand: HandMessage | None = None
    """Progress by hand; null while it works by itself."""
    updates: int
    """Measurement updates since the last set_pose, scatter or reset."""
    undoable: int
    """How many changes of the belief ``undo`` can take back."""
    broken: str | None
    """What is wrong with a user's own model, with file and line; the robot stands still and the
    filter pauses until it is fixed."""


class IntegrityMessage(Message):
    """How far the estimate can be trusted."""

    state: State
    """certain: one place, with a narrow bound; given: as somebody gave it, and not confirmed by
    scans yet; approximate: one place, with a wide bound or none;
    ambiguous: several places look alike; searching: no place stands out; lost: the place that was
    known does not fit any more."""
    radius: float | None
    """The robot is within this distance of the estimate [m], in 99.9 % of pictures; null if nothing
    is claimed."""
    heading_bound: float | None
    """Its heading is within this angle of the estimate's [rad]; null if nothing is claimed."""
    alerts: list[str]
    """Reasons for doubt in plain words, the newest first; empty if there are none."""


class RecordingMessage(Message):
    """The running recording, or the last one."""

    file: str
    """Name of the recording; ``/api/recordings`` lists it."""
    running: bool
    duration_s: float
    size_bytes: int
    message: str | None
    """Why the recording ended by itself, or what is missing in it; null when all is well."""


class ReplayMessage(Message):
    """State of a replay."""

    file: str
    position_s: float
    """Time since the recording's beginning."""
    duration_s: float
    speed: float
    """Seconds of the recording per second."""
    paused: bool
    catching_up: float | None
    """Progress of a seek to the requested time, 0 to 1; null when the replay is there."""
    estimate_then: PoseMessage | None
    """The recorded estimate."""
    robot_waits: bool = False
    """Whether ``close_recording`` goes back to a robot."""


class CalibrationDriveMessage(Message):
    """The running drive of a calibration, or the last one."""

    state: Literal["drive", "adjust", "done", "failed"]
    """drive: the robot drives; adjust: it stands, and the calibration is computed; done: it is
    calibrated; failed: its calibration is as before."""
    seconds: float
    """How long it has driven [s]."""
    whole: float
    """How long the whole drive is [s]."""
    fewest: float
    """After this time ``finish_calibration`` is accepted [s]."""
    adjusted: int
    """How many results there were; ``/api/calibration`` has the newest."""
    message: str | None
    """What is missing so far, or why it failed; null when all is well."""


class MappingMessage(Message):
    """The map that is drawn by driving, or the last one."""

    state: Literal["draw", "finish", "done", "failed"]
    """draw: it grows; finish: the whole map is adjusted; done: it can be saved; failed: there is
    none."""
    seconds: float
    """How long the drive is [s]."""
    paused: bool
    """Whether adding pictures to the map is paused."""
    version: int
    """How many drawings there were; ``/api/mapping`` has the newest."""
    pose: PoseMessage | None
    """The robot's pose in the new map; null before anything was drawn."""
    message: str | None
    """What is wrong or missing, or why it failed; null when all is well."""


class NavigationMessage(Message):
    """The journey to a goal, or the last one."""

    state: Literal["planning", "driving", "waiting", "arrived", "canceled", "failed"]
    remaining_m: float
    """The way to the next goal that is left [m]."""
    remaining_s: float
    """How long it takes [s]."""
    reason: str | None
    """Why the robot waits, was stopped or has failed; null when all is well."""
    number: int
    """Of the goal that it drives to, from 0."""
    target: PoseMessage | None
    """Where the robot shall be next."""
    planned: float
    """When the way was planned [s]; ``/api/navigation`` has it."""
    on_curve: bool = False
    """Whether it is a closed curve, lap after lap; what is left is that of the lap."""


class DriverMessage(Message):
    """Who drives."""

    name: str | None
    """Name of the client; null while nobody drives."""
    mine: bool
    """Whether it is this connection, or another page of the same browser."""
    this_page: bool
    """Whether it is this connection itself."""
    stopped: bool
    """Whether a stop holds: drive commands that only continue those before it are refused."""


class TelemetryMessage(Message):
    """Everything that one tick shows."""

    type: Literal["telemetry"] = "telemetry"
    stamp: float
    """The robot's clock [s]."""
    map: str
    truth: PoseMessage | None
    odometry: PoseMessage | None
    """Dead reckoning since the start (or the last ``place`` command), in the map."""
    estimate: EstimateMessage | None
    integrity: IntegrityMessage
    twist: TwistMessage
    wheels: list[float] | None = None
    """Measured speeds of the left and the right wheel [rad/s]."""
    mode: str
    """``idle``, ``drive``, ``figure_eight``, ``calibrate``, ``explore``, or a feature's own."""
    driver: DriverMessage
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
    calibration: CalibrationDriveMessage | None = None
    """Null before the first drive of a calibration."""
    mapping: MappingMessage | None = None
    """Null while no map is drawn."""
    navigation: NavigationMessage | None = None
    """Null before the first goal."""
    walls: float | None = None
    """When it was last said what the robot does not touch; ``/api/navigation/walls`` has it."""
    misplaced_tape: list[tuple[float, float, float, float]] | None = None
    """Edges (k, 4) of tape that does not lie where it is drawn: there [m]; null if all does."""
    replay: ReplayMessage | None = None
    """Null if this is not a replay."""
    values: Annotated[
        dict[str, bool | int | float | str | None] | None,
        Field(exclude_if=lambda values: values is None),
    ] = None
    """Further values, by name; absent without any."""
    hidden_layers: list[Layer] | None = None
    """Layers of the 3D view that are switched off for all viewers; null if there is no 3D view."""


class EdgesMessage(Message):
    """Where the scanner found tape in a picture."""

    entry_px: list[tuple[float, float] | None]
    """Pixel (u, v) where each ray enters the tape; null for a ray that did not count."""
    exit_px: list[tuple[float, float] | None]
    tape_width: float | None
    """Median width measured over the rays that counted [m]."""


class PictureMessage(Message):
    """Header of each binary message of ``/api/camera``.

    The message is the header's length in bytes (uint32, little-endian), the header as JSON, and the
    picture as JPEG.
    """

    type: Literal["picture"] = "picture"
    stamp: float
    """Stamp of its exposure [s]."""
    edges: EdgesMessage | None
    """What the scanner found in this picture; null if it was not scanned."""
