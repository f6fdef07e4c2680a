"""Named models: classes of a package, offered by its names, and guarded as a user's own are."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from app.engine.added_models import AddedModels, InUse, ModelChoice
from app.features.own_models.error_messages import OwnModelError
from app.features.own_models.guards import OwnMotion, OwnSensor
from app.features.own_models.model_file import ModelFile, build
from robot.fields.field import Field
from robot.localization.parameters import LocalizationParameters

G = TypeVar("G", OwnSensor, OwnMotion)
NO_CLASSES: Mapping[str, type] = MappingProxyType({})


class NamedModels(AddedModels):
    """Models whose classes are written as in a user's own file (``docs/own_models.md``).

    They are made when they are chosen, and again when a parameter changes; no file is watched.
    """

    def __init__(
        self,
        field: Field,
        *,
        sensors: Mapping[str, type] = NO_CLASSES,
        motions: Mapping[str, type] = NO_CLASSES,
    ) -> None:
        """Offer classes by their names on the page."""
        super().__init__()
        self._field = field
        self._classes = sensors, motions
        self._names = "", ""
        self._sensor: OwnSensor | None = None
        self._motion: OwnMotion | None = None
        self._made_of: tuple[tuple[str, str], LocalizationParameters] | None = None

    @property
    def choice(self) -> ModelChoice:
        """The models in use and on offer."""
        sensors, motions = self._classes
        return ModelChoice(*self._names, tuple(sensors), tuple(motions))

    @property
    def in_use(self) -> tuple[OwnSensor | None, OwnMotion | None]:
        """The models in use; None while another one is."""
        return self._sensor, self._motion

    @property
    def fault(self) -> str | None:
        """What is wrong with a model in use, with file and line."""
        return next((each.guard.fault for each in self.in_use if each and each.guard.fault), None)

    @property
    def trace(self) -> str:
        """The calls that led to the fault."""
        return next((each.guard.trace for each in self.in_use if each and each.guard.trace), "")

    def choose(self, choice: ModelChoice | None) -> None:
        """Choose models by name, None those of the start; ``make`` follows."""
        wanted = choice or ModelChoice()
        sensors, motions = self._classes
        self._names = (
            wanted.sensor if wanted.sensor in sensors else "",
            wanted.motion if wanted.motion in motions else "",
        )

    def make(self, parameters: LocalizationParameters, *, fresh: bool) -> None:
        """Make the chosen models; if nothing has changed, they and their faults stay."""
        if not fresh and self._made_of == (self._names, parameters):
            return
        self._made_of = self._names, parameters
        (sensors, motions), (sensor, motion), field = self._classes, self._names, self._field
        for_sensor = {"field": field, "parameters": parameters.sensor, "edges": field.edges}
        self._sensor = _guarded(OwnSensor, sensors.get(sensor), for_sensor)
        self._motion = _guarded(OwnMotion, motions.get(motion), {"parameters": parameters.motion})

    def put_back(self, in_use: InUse, parameters: LocalizationParameters) -> None:
        """Go on with models that were in use before."""
        sensor, motion = in_use
        assert sensor is None or isinstance(sensor, OwnSensor)
        assert motion is None or isinstance(motion, OwnMotion)
        self._sensor, self._motion = sensor, motion
        self._made_of = self._names, parameters


def _guarded(
    wrap: Callable[[ModelFile, object, str | None], G],
    made: Callable[..., Any] | None,
    offered: Mapping[str, object],
) -> G | None:
    if made is None:
        return None
    file = ModelFile(Path(inspect.getfile(made)), made.__name__)
    try:
        return wrap(file, build(file, made, offered), None)
    except OwnModelError as error:
        broken = wrap(file, None, str(error))
        broken.guard.trace = error.trace
        return broken
