"""Messages of the drive that calibrates the robot, and of the grid on its floor."""

from __future__ import annotations

from typing import Literal

from app.messages.message import CommandMessage, Message


class GridLineMessage(Message):
    """A part of a line on the floor that the picture shows."""

    pixels: list[tuple[float, float]]
    """Along it (u, v) [px]."""
    ahead: bool
    """Whether it is the line straight ahead of the robot."""


class GridLabelMessage(Message):
    """A distance ahead of the robot's axle, on the line straight ahead."""

    distance: float
    """[m]"""
    u: float
    v: float
    """Where it is in the picture [px]."""


class FloorGridMessage(Message):
    """The floor's grid, every 0.1 m, as the camera sees it."""

    lines: list[GridLineMessage]
    labels: list[GridLabelMessage]


class CalibrateCommand(CommandMessage):
    """Drive to calibrate the robot, until it is known where its camera is; at most two minutes.

    It holds as long as drive does, and continues if renewed. At its end the robot is calibrated
    by what it saw; ``stop`` leaves the calibration as it was.
    """

    type: Literal["calibrate"]
    start: bool = False
    """Whether to begin; without it the command only renews a drive that has begun."""


class FinishCalibrationCommand(CommandMessage):
    """End the calibration's drive, and calibrate the robot by what it has seen so far."""

    type: Literal["finish_calibration"]


class UndoCalibrationCommand(CommandMessage):
    """Go back to the calibration before the last one by driving; a second undo takes that back."""

    type: Literal["undo_calibration"]


class UnknownMessage(Message):
    """One number of the robot that is measured, in a unit for people."""

    name: str
    unit: str
    value: float
    """Difference from the description."""
    interval: float
    """Half of the 95 % interval around the value [same unit]."""
    prior: float
    """The same for a robot that was built by hand and not calibrated."""
    learnt: bool
    """Whether the drive determined it."""


class CalibrationMessage(Message):
    """What is known of the robot: by the last adjusted drive, or by its profile without one."""

    measured: str
    """When and from what the robot was calibrated; empty if it is as described."""
    undoable: bool
    """Whether ``undo_calibration`` can go back to another calibration."""
    unknowns: list[UnknownMessage]
    position: float | None
    """By how much these errors may shift the estimated place, in 95 % [m]; null without a drive."""
    advice: list[str]
    """Motions that would determine what is not known yet."""
    facts: list[str]
    """How well the last drive, or what the profile was measured by, fits; empty without both."""
    remarks: list[str]
    """What is wrong with it, or may be wrong."""


MESSAGES = (CalibrationMessage, FloorGridMessage)
