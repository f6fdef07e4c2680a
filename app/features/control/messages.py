"""Begun and the other messages between the process that controls the robot and the one that serves.

Commands go to control as they are; these are all others.
"""

from __future__ import annotations

from dataclasses import dataclass

from app.engine.added_models import ModelChoice
from app.engine.robot_facts import RobotFacts
from app.engine.snapshot import DrawnMap, Snapshot
from app.settings.config import Config
from robot.fields.field import Field
from robot.localization.estimate import Hypothesis
from robot.scanning.line_scanner import LineScanner


@dataclass(frozen=True)
class Go:
    """To control: begin to drive."""


@dataclass(frozen=True)
class Watched:
    """To control: who wants snapshots."""

    rate: float
    """How often somebody looks at the newest [1/s], besides new pictures; 0: nobody does."""
    every: bool
    """Whether anybody needs each one, as a recording does."""


@dataclass(frozen=True)
class PutMap:
    """To control: the map that is drawn by driving."""

    map: DrawnMap | None


@dataclass(frozen=True)
class Stop:
    """To control: end the loop."""

    hand_over: bool
    """Whether another loop goes on with the robot, as ``Follow`` will say."""


@dataclass(frozen=True)
class Follow:
    """To control, after a stop that handed the robot over: begin on another field."""

    name: str
    """Of the field, as ``Config.map``."""
    field: Field
    place: Hypothesis | None
    """Where the robot is in it; None: at its start."""


@dataclass(frozen=True)
class Begun:
    """From control: a program is built, and waits for ``Go``."""

    facts: RobotFacts
    field: Field
    config: Config
    given: ModelChoice
    """The user's own models at the start."""
    scanner: LineScanner


@dataclass(frozen=True)
class Refused:
    """From control: no program could be built."""

    error: Exception


@dataclass(frozen=True)
class SentTick:
    """From control: a snapshot."""

    snapshot: Snapshot
    unbroken: bool
    """Whether it follows the last one that was so, with no tick between them."""


@dataclass(frozen=True)
class Hangs:
    """From control: no tick for a while."""

    where: tuple[str, ...]
    """In words, which lines of users' files are running."""


@dataclass(frozen=True)
class Ended:
    """From control: the loop has ended, and the robot stands."""

    failure: str | None
    """Why it failed; None if it was asked to end."""
