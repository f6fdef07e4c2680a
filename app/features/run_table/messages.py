"""Messages on runs: what each comes to, and how it differs from another one."""

from __future__ import annotations

from app.messages.message import Message


class RunDifferenceMessage(Message):
    """How the error of a run differs from that of the run it is compared with."""

    rmse: float
    """Root mean square error of the run less the other one's [m]."""
    low: float | None
    high: float | None
    """Interval that holds the difference in 95 % [m]; null if a run is shorter than ten seconds."""
    paired: bool
    """Whether both saw the same pictures."""


class RunMessage(Message):
    """One run, over all of it or over its end."""

    number: int
    file: str
    """Name of the recording that it replays; empty if the robot drove."""
    field: str
    recorded: bool
    """Whether its estimates are those that the recording has."""
    present: bool
    """Whether it goes on."""
    kept: bool
    parameters: dict[str, float | str | bool]
    """The filter's parameters that are not as they were at the start, by name."""
    standard: dict[str, float | str | bool]
    """The same ones as they were at the start."""
    units: dict[str, str]
    """Their units, where they have any."""
    pictures: int
    seconds: float
    """How long the pictures that count go on [s]."""
    rmse: float | None
    """Root mean square of the distances from the truth [m]; null without an estimate."""
    median: float | None
    """[m]"""
    worst: float | None
    """[m]"""
    lost: float
    """Share of the pictures at which the estimate is not within 50 mm and 10 degrees."""
    misleading: float | None
    """Share of the pictures at which it says certain and the truth lies outside its bounds; null
    where that is not recorded."""
    time_to_right: float | None
    """From the beginning until it is right for a second [s]; null if it never is."""
    difference: RunDifferenceMessage | None
    """From the run that all are compared with; null for that run itself."""


class RunsMessage(Message):
    """The runs that are listed, the newest first."""

    against: int | None
    """Number of the run that all are compared with."""
    runs: list[RunMessage]


MESSAGES = (RunsMessage,)
