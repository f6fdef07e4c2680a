"""Messages on how particles are weighed, and commands to step the filter by hand."""

from __future__ import annotations

from typing import Literal

from app.messages.message import CommandMessage, Message
from app.messages.telemetry import PoseMessage


class ProfileMessage(Message):
    """What the scanner saw along one ray of the newest frame."""

    stamp: float
    ray: int
    bearing: float
    distances: list[float]
    """Distance of each sample from the rays' centre, on the floor [m]."""
    grey: list[float]
    """Brightness, 0 to 255."""
    response: list[float]
    """Response of the edge kernel, in grey levels; negative where it gets darker."""
    threshold: float
    entry: float | None
    """Distance of the entry edge [m]."""
    exit: float | None
    width: float | None
    """Width measured across the line [m]."""
    counted: bool
    why: str
    """Why the ray counted or not, in plain words."""


class PoseFitMessage(PoseMessage):
    """How the scan fits a pose."""

    log_likelihood: float
    """Log-likelihood of the whole scan, up to a constant."""
    weight: float
    """Factor by which this scan multiplies a weight there, relative to the estimate's. The filter
    takes the scan as worth less where hardly a particle would be left."""
    expected: list[float | None]
    """Expected range of each ray there [m]; null where it meets no tape."""
    shares: list[float | None] | None
    """Share of each ray in the log-likelihood, null if the ray does not count; null if computing
    the shares takes too long."""
    rest: float
    """Log-likelihood minus the rays' shares; not zero only for models of one's own."""


class PoseFitsMessage(Message):
    """How the current scan fits a pose, and the estimate."""

    stamp: float
    """Stamp of the exposure of the scan's picture [s]."""
    model: str
    """The sensor model."""
    power: float
    """Share of the log-likelihood that counts in a weight."""
    extra_sd: float
    """Standard deviation [m] added (in squares) to the ranges', because the particles lie apart."""
    bearings: list[float]
    ranges: list[float | None]
    """Measured ranges [m]; null means no return."""
    robot_from_scan: PoseMessage
    """Where the rays start, in the robot frame."""
    asked: PoseFitMessage
    """The pose that was asked for, or the particle nearest to the place."""
    particle: float | None
    """That particle's weight, as a multiple of the mean; null if a pose was asked for."""
    best: PoseFitMessage | None
    """The estimate; null while there is none."""


class LandscapeMessage(Message):
    """How the scan fits all over the field, at one heading."""

    stamp: float
    model: str
    x: float
    y: float
    """Middle of the first cell [m]."""
    step: float
    """Side of a cell [m]."""
    columns: int
    rows: int
    theta: float
    lowest: float
    """Log-weight of the value 0 in ``cells``, relative to the best cell, which is 255; smaller ones
    are 0, too."""
    cells: str
    """base64 of one byte per cell, row by row from the lowest y."""
    best: PoseMessage
    """The best cell."""
    seconds: float
    """How long it took to compute [s]."""


class HeadingsMessage(Message):
    """How the scan fits in all directions at a place."""

    stamp: float
    thetas: list[float]
    logs: list[float]
    """Log-weight of each, relative to the best."""
    seconds: float


class HandStepMessage(Message):
    """The last step by hand, and what it did to the particles."""

    number: int
    """As in telemetry."""
    last: Literal["predict", "weigh", "resample"] | None
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] of the area that x and y in the clouds span."""
    before: str
    """All particles before the step, packed as ``ParticlesMessage.cloud``; empty before the first
    step."""
    after: str
    """The particles after it."""
    noiseless: str
    """After predict: where odometry alone would have moved each particle; else empty."""
    parents: list[int]
    """After resample: the index of each particle's parent, -1 without one; else empty."""
    moved: PoseMessage | None
    """After predict: the step by odometry, in the robot frame."""
    noise: PoseMessage | None
    """After predict: standard deviations of the noise: ahead, aside and in heading."""
    effective_before: float | None
    effective: float
    """Effective sample size."""


class FilterByHandCommand(CommandMessage):
    """Let the particle filter wait for steps by hand, or work by itself again.

    Another filter is replaced by it, and it begins at the heaviest place of that one.

    Odometry gathers meanwhile; the next prediction uses all of it.
    """

    type: Literal["filter_by_hand"]
    on: bool


class FilterStepCommand(CommandMessage):
    """Take one step of the particle filter by hand.

    predict: move the particles by odometry up to the newest picture, with noise. weigh: weigh them
    by that picture. resample: draw the particles that survive. Each follows the one before it;
    predict is always possible.
    """

    type: Literal["filter_step"]
    step: Literal["predict", "weigh", "resample"]


class FilterUndoCommand(CommandMessage):
    """Take back the last step by hand, random numbers included."""

    type: Literal["filter_undo"]


MESSAGES = (ProfileMessage, PoseFitsMessage, LandscapeMessage, HeadingsMessage, HandStepMessage)
