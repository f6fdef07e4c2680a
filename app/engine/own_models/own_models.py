"""A user's own models as the engine uses them: offered, chosen, and loaded again when saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from app.engine.own_models.guards import OwnMotion, OwnSensor
from app.engine.own_models.model_file import ModelFile
from app.engine.own_models.slot import Slot
from app.engine.own_models.trial import judge_on
from app.engine.own_models.watch import ModelFolder, ModelList
from robot.fields.field import Field
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

POLL_S = 0.2
"""Interval between checks of the files, on the robot's clock [s]; a save takes effect after two."""

SLOW_S = 0.05
"""A longer call [s] delays the robot's next step; it is reported, but not ended."""


PATIENCE = 50
"""Updates after which a model that was not called is reported: some filters do not use it."""


@dataclass(frozen=True, slots=True)
class OwnChoice:
    """Names of the user's own models in use and on offer (``my_model.py:MyModel``)."""

    sensor: str = ""
    """Empty while one of the program's own models is in use."""
    motion: str = ""
    sensors: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()


class OwnModels:
    """The user's sensor and motion model, and the folder with more of them."""

    def __init__(
        self, field: Field, *, sensor: str = "", motion: str = "", folder: str = ""
    ) -> None:
        """Note which models are given; no file is run before ``load``.

        Raises:
            SettingError: a model's file or the folder does not exist.
        """
        self._field = field
        self._folder = _folder(folder) if folder else None
        self._given_sensor = ModelFile.find(sensor) if sensor else None
        self._given_motion = ModelFile.find(motion) if motion else None
        self._found = self._folder.look() if self._folder else ModelList()
        self._sensor = Slot(OwnSensor, field.start, judge_on(field))
        self._motion = Slot(OwnMotion, field.start)
        self._polled = float("-inf")
        self._made_with: LocalizationParameters | None = None
        self.saves = 0
        """How many times files in use were saved."""
        self.reset()

    @property
    def sensor(self) -> OwnSensor | None:
        """The user's sensor model; None while another one is chosen."""
        return self._sensor.model

    @property
    def motion(self) -> OwnMotion | None:
        """The user's motion model; None while another one is chosen."""
        return self._motion.model

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
            "own models": self.fault and f"The robot stands still: {self.fault}",
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
    def choice(self) -> OwnChoice:
        """The models in use and on offer."""
        return OwnChoice(
            self._sensor.name,
            self._motion.name,
            tuple(self._sensors()),
            tuple(self._motions()),
        )

    def choose(self, choice: OwnChoice) -> bool:
        """Choose other models by name; return whether one must be loaded now."""
        chosen = [
            _switch(self._sensor, self._sensors().get(choice.sensor)),
            _switch(self._motion, self._motions().get(choice.motion)),
        ]
        return any(chosen)

    def reset(self) -> bool:
        """Choose the models given at the start; return whether one must be loaded now."""
        return any(
            [_switch(self._sensor, self._given_sensor), _switch(self._motion, self._given_motion)]
        )

    def saved(self, stamp: float) -> bool:
        """Check the files every ``POLL_S``; return whether one was saved, so ``load`` is due."""
        if stamp - self._polled < POLL_S:
            return False
        self._polled = stamp
        if self._folder is not None:
            self._found = self._folder.look()
        saved = any([self._sensor.saved(), self._motion.saved()])
        self.saves += saved
        return saved

    def look_again(self) -> None:
        """Let ``saved`` check the files at once, as the robot's clock stands or was set back."""
        self._polled = float("-inf")

    def put_back(self, sensor: OwnSensor | None, motion: OwnMotion | None) -> None:
        """Restore models that were in use before, from the same files."""
        self._sensor.model, self._motion.model = sensor, motion

    def load(self, parameters: LocalizationParameters) -> None:
        """Read the files of the chosen models and make the models; ``fault`` has failures."""
        self._made_with = parameters
        self._sensor.load(self._for_sensor(parameters))
        self._motion.load({"parameters": parameters.motion})

    def rebuild(self, parameters: LocalizationParameters) -> None:
        """Make the chosen models again with other parameters, without reading their files.

        If ``load`` has just made them with these parameters, they stay, and so do their faults.
        """
        if parameters == self._made_with:
            return
        self._made_with = parameters
        self._sensor.rebuild(self._for_sensor(parameters))
        self._motion.rebuild({"parameters": parameters.motion})

    def _for_sensor(self, parameters: LocalizationParameters) -> dict[str, object]:
        field = self._field
        return {"field": field, "parameters": parameters.sensor, "edges": field.edges}

    def _sensors(self) -> dict[str, ModelFile]:
        return _by_name((*self._found.sensors, self._given_sensor, self._sensor.file))

    def _motions(self) -> dict[str, ModelFile]:
        return _by_name((*self._found.motions, self._given_motion, self._motion.file))


def chosen(own_choice: OwnChoice, values: dict[str, object]) -> tuple[OwnChoice, dict[str, object]]:
    """Take the user's own models out of a change of parameters.

    Returns the new choice of models, and the remaining values.

    Raises:
        SettingError: a model is not on offer.
    """
    left = dict(values)
    sensor = _taken(left, "laser_model_type", own_choice.sensor, own_choice.sensors)
    motion = _taken(left, "robot_model_type", own_choice.motion, own_choice.motions)
    return OwnChoice(sensor, motion, own_choice.sensors, own_choice.motions), left


def _taken(values: dict[str, object], key: str, current: str, offered: tuple[str, ...]) -> str:
    wanted = values.get(key)
    if wanted is None:
        return current
    if not isinstance(wanted, str) or ":" not in wanted:
        return ""  # one of the program's own models, or a wrong name, which is refused later
    if wanted not in offered:
        raise SettingError(
            f"there is no model {wanted}; of your own are on offer: {', '.join(offered) or 'none'}"
        )
    del values[key]
    return wanted


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
