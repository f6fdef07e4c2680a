"""Changes the filter's parameters while it runs, by bare names as the page uses them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from app.engine.own_models.own_models import OwnChoice, chosen
from app.settings.config import with_settings
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError, describe


def with_values_and_models(
    parameters: LocalizationParameters, choice: OwnChoice, values: Mapping[str, Any]
) -> tuple[LocalizationParameters, OwnChoice]:
    """Do as ``changed``, but accept the user's own models, too (``my_model.py:MyModel``).

    Raises:
        SettingError: a name is unknown, or a value out of range or of the wrong type.
    """
    choice, rest = chosen(choice, dict(values))
    return changed(parameters, rest), choice


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
