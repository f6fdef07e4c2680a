"""Settings that the page shows as rows: those of the filter, and their meanings."""

from __future__ import annotations

import dataclasses
import math

from app.engine.added_models import ModelChoice
from app.messages.answers import ParameterMessage
from robot.localization.parameters import LocalizationParameters
from robot.localization.used_parameters import idle_parameters
from robot.settings import Setting, describe


def parameter_messages(
    localization_parameters: LocalizationParameters,
    default: LocalizationParameters,
    models: ModelChoice,
    given: ModelChoice,
) -> list[ParameterMessage]:
    """Return each parameter of the filter with its meaning; models of features are choices, too.

    Args:
        localization_parameters: the present parameters.
        default: the parameters at the start.
        models: models of features, in use and on offer.
        given: models of features at the start.
    """
    result = []
    idle = idle_parameters(
        localization_parameters, own_motion=bool(models.motion), own_sensor=bool(models.sensor)
    )
    choices = {
        "laser_model_type": (models.sensor, given.sensor, models.sensors),
        "robot_model_type": (models.motion, given.motion, models.motions),
    }
    for group in dataclasses.fields(localization_parameters):
        values, defaults = (
            getattr(localization_parameters, group.name),
            getattr(default, group.name),
        )
        for name, known in describe(values).items():
            chosen, first, offered = choices.get(name, ("", "", ()))
            value = chosen or getattr(values, name)
            standard = first or getattr(defaults, name)
            message = parameter_message(group.name, name, known, value, standard, offered)
            result.append(message.model_copy(update={"used": name not in idle}))
    return result


def parameter_message(
    group: str,
    name: str,
    known: Setting,
    value: object,
    default: object,
    more_choices: tuple[str, ...] = (),
) -> ParameterMessage:
    """Return a setting as a message."""
    return ParameterMessage.model_validate(
        {
            "name": name,
            "group": group,
            "value": value,
            "default": default,
            "meaning": known.meaning,
            "unit": known.unit,
            "low": known.low if math.isfinite(known.low) else None,
            "high": known.high if math.isfinite(known.high) else None,
            "choices": [*known.choices, *more_choices],
            "integer": isinstance(default, int) and not isinstance(default, bool),
        }
    )
