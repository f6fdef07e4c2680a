"""A user's own models as the engine uses them: offered, chosen, and loaded again when saved."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from app.engine.added_models import AddedModels, InUse, ModelChoice
from app.features.own_models.error_messages import running
from app.features.own_models.guards import OwnMotion, OwnSensor
from app.features.own_models.model_file import ModelFile
from app.features.own_models.slot import Slot
from app.features.own_models.trial import judge_on
from app.features.own_models.watch import ModelFolder, ModelList
from app.settings.config import Config
from robot.fields.field import Field
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

POLL_S = 0.2
"""Interval between checks of the files, on the robot's clock [s]; a save takes effect after two."""

SLOW_S = 0.05
"""A longer call [s] delays the robot's next step; it is reported, but not ended."""


PATIENCE = 50
"""Updates after which a model that was not called is reported: some filters do not use it."""


class OwnModels(AddedModels):
    """The user's sensor and motion model, and the folder with more of them."""

    def __init__(
        self, field: Field, *, sensor: str = "", motion: str = "", folder: str = ""
    ) -> None:
        """Note which models are given; no file is run before ``make``.

        Raises:
            SettingError: a model's file or the folder does not exist.
        """
        super().__init__()
        self._field = field
        self._folder = _folder(folder) if folder else None
        self._given_sensor = ModelFile.find(sensor) if sensor else None
        self._given_motion = ModelFile.find(motion) if motion else None
        self._found = self._folder.look() if self._folder else ModelList()
        self._sensor = Slot(OwnSensor, field.start, judge_on(field))
        self._motion = Slot(OwnMotion, field.start)
        self._polled = float("-inf")
        self._made_with: LocalizationParameters | None = None
        self._switched = False
        """Whether other files have been chosen, which are not yet read."""
        self.choose(None)

    @property
    def in_use(self) -> tuple[OwnSensor | None, OwnMotion | None]:
        """The user's models; None while another one is chosen."""
        return self._sensor.model, self._motion.model

    @property
    def fault(self) -> str | None:
        """What is wrong with a model in use, with file and line."""
        return self._sensor.fault or self._motion.fault

    @property
    def trace(self) -> str:
        """The calls that led to the fault, from the user's file on; empty if there is none."""
        return self._sensor.trace or self._motion.trace

    @property
    def complaints(self) -> tuple[str, ...]:
        """What is wrong with files that are not in use."""
        used = [slot.file.path.name for slot in (self._sensor, self._motion) if slot.file]
        return tuple(fault for fault in self._found.faults if not fault.startswith(tuple(used)))

    @property
    def problems(self) -> Mapping[str, str | None]:
        """What is wrong, by topic; None if nothing is."""
        return {
            "doubtful models": self._doubt,
            "slow models": self.slow,
            "idle models": self.idle,
            "models on offer": " ".join(self.complaints) or None,
        }

    @property
    def _doubt(self) -> str | None:
        doubt = None if self.fault else self._sensor.doubt
        return f"{self._sensor.name}: {doubt}" if doubt else None

    @property
    def slow(self) -> str | None:
        """Message about a model that takes too long; None if none does."""
        for slot in (self._sensor, self._motion):
            if slot.model is not None and slot.model.guard.seconds > SLOW_S:
                took = 1e3 * slot.model.guard.seconds
                most = 1e3 * SLOW_S
                return f"{slot.name} takes {took:.0f} ms; more than {most:.0f} ms delays the robot."
        return None

    def note_update(self) -> None:
        """Note that the filter has taken a scan; ``idle`` reports a model that it does not call."""
        for slot in (self._sensor, self._motion):
            if slot.model is not None:
                slot.model.guard.passed_over += 1

    @property
    def idle(self) -> str | None:
        """Message about a model that the filter does not call; None if there is none."""
        for slot in (self._sensor, self._motion):
            if slot.model is not None and slot.model.guard.passed_over > PATIENCE:
                return (
                    f"{slot.name} is not used: no tape is in sight, or this filter needs no "
                    "sensor model."
                )
        return None

    @property
    def choice(self) -> ModelChoice:
        """The models in use and on offer (``my_model.py:MyModel``)."""
        return ModelChoice(
            self._sensor.name,
            self._motion.name,
            tuple(self._sensors()),
            tuple(self._motions()),
        )

    def choose(self, choice: ModelChoice | None) -> None:
        """Choose models by name, None those of the start; ``make`` follows."""
        sensor, motion = self._given_sensor, self._given_motion
        if choice is not None:
            sensor = self._sensors().get(choice.sensor)
            motion = self._motions().get(choice.motion)
        self._switched |= _switch(self._sensor, sensor)
        self._switched |= _switch(self._motion, motion)

    def saved(self, stamp: float, *, at_once: bool) -> bool:
        """Check the files every ``POLL_S``; return whether one in use was saved."""
        if not at_once and stamp - self._polled < POLL_S:
            return False
        self._polled = stamp
        if self._folder is not None:
            self._found = self._folder.look()
        return any([self._sensor.saved(), self._motion.saved()])

    def put_back(self, in_use: InUse, parameters: LocalizationParameters) -> None:
        """Restore models that were in use before, from the same files."""
        sensor, motion = in_use
        assert sensor is None or isinstance(sensor, OwnSensor)
        assert motion is None or isinstance(motion, OwnMotion)
        self._sensor.model, self._motion.model = sensor, motion
        self._made_with = parameters

    def make(self, parameters: LocalizationParameters, *, fresh: bool) -> None:
        """Make the chosen models, ``fresh`` from their files as they are; ``fault`` has failures.

        If they have just been made with these parameters, they stay, and so do their faults.
        """
        fresh = fresh or self._switched
        if not fresh and parameters == self._made_with:
            return
        self._switched, self._made_with = False, parameters
        field = self._field
        for_sensor = {"field": field, "parameters": parameters.sensor, "edges": field.edges}
        self._sensor.make(for_sensor, fresh=fresh)
        self._motion.make({"parameters": parameters.motion}, fresh=fresh)

    def running(self, thread: int | None) -> str | None:
        """Return in words which line of a user's file a thread is running."""
        return running(thread)

    def _sensors(self) -> dict[str, ModelFile]:
        return _by_name((*self._found.sensors, self._given_sensor, self._sensor.file))

    def _motions(self) -> dict[str, ModelFile]:
        return _by_name((*self._found.motions, self._given_motion, self._motion.file))


def own_models(config: Config, field: Field) -> tuple[OwnModels]:
    """Return the user's own models that the configuration names."""
    own = OwnModels(
        field, sensor=config.sensor_model, motion=config.motion_model, folder=config.models
    )
    return (own,)


def _switch(slot: Slot[OwnSensor] | Slot[OwnMotion], file: ModelFile | None) -> bool:
    if slot.file == file:
        return False
    slot.choose(file)
    return file is not None


def _by_name(files: tuple[ModelFile | None, ...]) -> dict[str, ModelFile]:
    return {file.name: file for file in files if file is not None}


def _folder(folder: str) -> ModelFolder:
    path = Path(folder)
    if not path.is_dir():
        raise SettingError(f"there is no folder {path.absolute()} of models")
    return ModelFolder(path.absolute())
