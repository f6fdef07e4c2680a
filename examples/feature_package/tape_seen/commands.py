"""A command, which creeps ahead until tape is near, and a value: how many rays meet tape."""

from typing import Literal

import numpy as np

from app.engine.command_row import CommandRow, TickContext
from app.engine.driving_commands import require_drivable
from app.engine.snapshot import Snapshot
from app.engine.value import Value
from app.messages.message import CommandMessage
from robot.geometry import Twist2

NEAR_M = 0.25
SPEED = 0.05


class CreepCommand(CommandMessage):
    """Creep ahead while tape is seen, until it is 25 cm away; renew it as a drive command."""

    type: Literal["creep"]


def rows() -> tuple[CommandRow, ...]:
    """Return what the table of commands gets."""
    return (CommandRow(CreepCommand, _creep, allowed=require_drivable, drives=True),)


def _creep(tick: TickContext[CreepCommand]) -> None:
    seen = tick.localization.line_scan
    clear = seen is not None and NEAR_M < np.min(seen.scan.ranges) < np.inf
    tick.controls.driving.drive(Twist2(SPEED if clear else 0.0, 0.0), tick.controls.stamp)


def values() -> tuple[Value, ...]:
    """Return what each tick shows besides."""
    return (Value("tape_rays", _rays),)


def _rays(snapshot: Snapshot) -> int | None:
    seen = snapshot.filter.line_scan
    return None if seen is None else int(np.isfinite(seen.scan.ranges).sum())
