"""Changes the filter's parameters while it runs, by bare names as the page uses them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from app.engine.added_models import ModelChoice
from app.settings.config import with_settings
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError, describe


def with_values_and_models(
    parameters: LocalizationParameters, choice: ModelChoice, values: Mapping[str, Any]
) -> tuple[LocalizationParameters, ModelChoice]:
    """Do as ``changed``, but accept models of features, too (``my_model.py:MyModel``).

    Raises:
        SettingError: a name is unknown, or a value out of range or of the wrong type.
    """
    rest = dict(values)
    sensor = _taken(rest, "laser_model_type", choice.sensor, choice.sensors)
    motion = _taken(rest, "robot_model_type", choice.motion, choice.motions)
    return changed(parameters, rest), dataclasses.replace(choice, sensor=sensor, motion=motion)


def _taken(values: dict[str, Any], key: str, current: str, offered: tuple[str, ...]) -> str:
    """Take a model of a feature out of a change; return the one that is then in use."""
    wanted = values.get(key, current)
    if wanted in offered:
        return str(values.pop(key, wanted))
    if key in values and isinstance(wanted, str) and ":" in wanted:
        raise SettingError(
            f"there is no model {wanted}; of your own are on offer: {', '.join(offered) or 'none'}"
        )
    return ""  # one of the program's own models, or a wrong name, which is refused later


def changed(
    parameters: LocalizationParameters, values: Mapping[str, Any]
) -> LocalizationParameters:
    """Return the parameters with some values replaced by name: all of them or none.

    Raises:
        SettingError: a name is unknown, or a value out of range or of the wrong type.
    """
    rest = {name: _whole(value) for name, value in values.items()}
    groups: dict[str, Any] = {}
    for group in dataclasses.fields(parameters):
        old = getattr(parameters, group.name)
        mine = {name: rest.pop(name) for name in describe(old) if name in rest}
        groups[group.name] = with_settings(old, mine)
    if rest:
        names = sorted(name for group in groups.values() for name in describe(group))
        raise SettingError(f"{min(rest)} is unknown; valid are {', '.join(names)}")
    return LocalizationParameters(**groups)


def changed_values(
    parameters: LocalizationParameters, before: LocalizationParameters
) -> dict[str, Any]:
    """Return the values by name that differ from those of other parameters."""
    values: dict[str, Any] = {}
    for group in dataclasses.fields(parameters):
        new, old = getattr(parameters, group.name), getattr(before, group.name)
        names = [name for name in describe(new) if getattr(new, name) != getattr(old, name)]
        values |= {name: getattr(new, name) for name in names}
    return values


def _whole(value: Any) -> Any:
    """Return a whole number as an int: values from a page do not distinguish 3.0 from 3."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
