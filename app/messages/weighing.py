"""Messages of how particles are weighed: single poses, all of the field, and steps by hand."""

from __future__ import annotations

from typing import Literal

from app.messages.message import Message
from app.messages.telemetry import PoseMessage


class PoseFitMessage(PoseMessage):
    """How the scan fits a pose."""

    log_likelihood: float
    """Of the whole scan, up to a constant."""
    weight: float
    """By how much a weight there is multiplied, against the estimate; with all of the scan's
    worth, which counts less where hardly a particle would be left."""
    expected: list[float | None]
    """Range that each ray should have there [m]; null where it meets no tape."""
    shares: list[float | None] | None
    """Of each ray in the log-likelihood; null if it does not count. Null if that takes too
    long."""
    rest: float
    """What is left of the log-likelihood besides the rays' shares: of a model of one's own."""


class PoseFitsMessage(Message):
    """How the scan by which particles are weighed now fits a pose, and the estimate."""

    stamp: float
    """Exposure of the scan's picture [s]."""
    model: str
    """The sensor model."""
    power: float
    """Share of the log-likelihood that counts in a weight."""
    extra_sd: float
    """How much less ranges are believed, as the particles lie apart [m]."""
    bearings: list[float]
    ranges: list[float | None]
    """Measured [m]; null is no return."""
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
    """Log of the weight at 0 in ``cells``, against the best cell's, which is 255; all below it is
    0, too."""
    cells: str
    """base64 of one byte a cell, row by row from the lowest y."""
    best: PoseMessage
    """The best cell."""
    seconds: float
    """How long it took."""


class HeadingsMessage(Message):
    """How the scan fits in all directions at a place."""

    stamp: float
    thetas: list[float]
    logs: list[float]
    """Log of the weight at each, against the best one's."""
    seconds: float


class HandStepMessage(Message):
    """The last step by hand, and what it did to the particles."""

    number: int
    """As in telemetry."""
    last: Literal["predict", "weigh", "resample"] | None
    extent: list[float]
    """xmin, ymin, xmax, ymax [m] of the area that x and y in the clouds span."""
    before: str
    """The particles before it, all of them, packed as ``ParticlesMessage.cloud``; empty before the
    first step."""
    after: str
    """The particles as they stand."""
    noiseless: str
    """Of a prediction: where odometry alone had moved each particle; else empty."""
    parents: list[int]
    """Of a resampling: of which particle before it each is a copy, -1 of none; else empty."""
    moved: PoseMessage | None
    """Of a prediction: the step by odometry, in the robot frame."""
    noise: PoseMessage | None
    """Of a prediction: standard deviation of the noise that was drawn, ahead, aside and turned."""
    effective_before: float | None
    effective: float
    """Effective sample size."""
