"""The models of a filter: the program's own by the parameters, or a feature's."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from app.engine.added_models import AddedModels
from robot.fields.field import Field
from robot.localization.filter import Setup
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel, SensorParameters, sensor_model
from robot.localization.parameters import LocalizationParameters


class FilterModels:
    """Makes the setup of a filter, and keeps the table of distances that models share."""

    def __init__(self, field: Field, entries: EntryField | None = None) -> None:
        self.sensor: SensorModel
        """In use, since the first setup."""
        self.usual = False
        """Whether that is one of ours, with its usual parameters."""
        self._field = field
        self._entries = entries

    @property
    def entries(self) -> EntryField:
        """The table of distances that the models use."""
        assert self._entries is not None
        return self._entries

    def is_slow_to_use(self, parameters: LocalizationParameters) -> bool:
        """Return whether parameters need a new table of distances, which may take some seconds."""
        wanted, made = parameters.sensor, self._entries
        return made is None or (made.wanted_resolution, made.max_distance) != (
            wanted.field_resolution,
            wanted.laser_likelihood_max_dist,
        )

    def setup(self, parameters: LocalizationParameters, added: Iterable[AddedModels]) -> Setup:
        """Return field, models and parameters for a filter; features' models come first."""
        wanted = parameters.sensor
        if self.is_slow_to_use(parameters):
            self._entries = EntryField.build(
                self._field,
                resolution=wanted.field_resolution,
                max_distance=wanted.laser_likelihood_max_dist,
            )
        self.sensor = sensor_model(wanted, self.entries, self._field.edges)
        self.usual = wanted == replace(SensorParameters(), laser_model_type=wanted.laser_model_type)
        motion: MotionModel = parameters.motion.model()
        for models in added:
            own_sensor, own_motion = models.in_use
            self.sensor, motion = own_sensor or self.sensor, own_motion or motion
            self.usual = self.usual and own_sensor is None
        return Setup.of(self._field, self.entries, motion, self.sensor, parameters)
