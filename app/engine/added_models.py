"""Models of sensor and motion that features add to ours, and their choice by name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.estimate import Alert
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel
from robot.localization.monitoring.monitor import Monitor
from robot.localization.parameters import LocalizationParameters
from robot.scan import Scan

InUse = tuple[SensorModel | None, MotionModel | None]


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """Names of models of features, in use and on offer."""

    sensor: str = ""
    """Empty while one of the program's own models is in use."""
    motion: str = ""
    sensors: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()


class Clearing(IntEnum):
    """By what a feature clears scans: by the scan alone, by motion, or by the drawing.

    In this order: each gets scans as those before it have cleared them.
    """

    VIEW, MOTION, MAP = range(3)


class AddedModels:
    """Models of a feature, none by default; the engine's thread calls all but ``running``."""

    clearing = Clearing.VIEW
    memory: Any = None
    """What scans have left in it: a replay keeps copies, and puts them back."""

    def __init__(self, problems: Mapping[str, str | None] = MappingProxyType({})) -> None:
        """Offer nothing; ``problems`` say why."""
        self._problems = problems

    @property
    def choice(self) -> ModelChoice:
        """The models in use and on offer."""
        return ModelChoice()

    @property
    def in_use(self) -> InUse:
        """The models in use; None while another one is. They raise no errors: see ``fault``."""
        return None, None

    @property
    def fault(self) -> str | None:
        """Why a model in use gives nothing, for people; the robot stands still meanwhile."""
        return None

    @property
    def trace(self) -> str:
        """The calls that led to the fault; empty if they are not known."""
        return ""

    @property
    def problems(self) -> Mapping[str, str | None]:
        """What is wrong, by topic; None if nothing is."""
        return self._problems

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """Reasons for doubt that it sees; those that the filter finds are their consequences."""
        return ()

    def choose(self, choice: ModelChoice | None) -> None:
        """Choose models by name, None those of the start; ``make`` follows."""

    def make(self, parameters: LocalizationParameters, *, fresh: bool) -> None:
        """Make what is chosen, if choice or parameters are others; ``fresh`` in any case."""

    def saved(self, stamp: float, *, at_once: bool) -> bool:
        """Return whether files in use were saved; ``at_once``: the clock [s] may stand."""
        return False

    def put_back(self, in_use: InUse, parameters: LocalizationParameters) -> None:
        """Go on with what was in use before, by the same choice, made with these parameters."""

    def cleared(self, scan: Scan, odometry: Pose2) -> Scan:
        """Return a scan without what is no tape, as seen at its stamp; ``odometry`` is then."""
        return scan

    def advise(self, monitor: Monitor) -> None:
        """Tell the filter's monitor what the newest scan shows that it cannot know."""

    def note_update(self) -> None:
        """Note that the filter has taken a scan, whether it has asked a model or not."""

    def running(self, thread: int | None) -> str | None:
        """Return in words where in a model a thread hangs, by its ``ident``; None if nowhere."""
        return None


NewModels = Callable[[Config, Field], Iterable[AddedModels]]
"""Makes models for a field; the feature's settings and files decide which."""


def choice_of(added: Iterable[AddedModels]) -> ModelChoice:
    """Return the models in use and on offer of all features; equal ones are one object."""
    each = [models.choice for models in added]
    return _choice(
        "".join(choice.sensor for choice in each),  # at most one of them has one in use
        "".join(choice.motion for choice in each),
        tuple(name for choice in each for name in choice.sensors),
        tuple(name for choice in each for name in choice.motions),
    )


_choice = lru_cache(maxsize=8)(ModelChoice)
