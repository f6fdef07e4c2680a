"""Settings with their meaning, unit and range, checked when they are made.

A group of settings is a frozen dataclass whose fields are made by ``setting``. The command line,
the configuration file, the dashboard and the documentation all read the same field.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

from robot.errors import BrickPoseError


class SettingError(BrickPoseError, ValueError):
    """A setting is unknown, of the wrong type or out of its range."""

    exit_code = 2


@dataclass(frozen=True, slots=True)
class Setting:
    """Meaning, unit and valid values of one setting."""

    meaning: str
    unit: str
    low: float
    high: float
    choices: Collection[str]


def setting(
    default: Any,
    meaning: str,
    *,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    choices: Collection[str] = (),
) -> Any:
    """Return a dataclass field with its meaning; ``low`` and ``high`` are themselves allowed.

    ``choices`` is asked anew at each check, so a table that grows may be given.
    """
    known = Setting(meaning, unit, low, high, choices)
    return dataclasses.field(default=default, metadata={"setting": known})


def describe(group: Any) -> dict[str, Setting]:
    """Return the settings of a dataclass (or of an instance) by name."""
    return {
        f.name: f.metadata["setting"] for f in dataclasses.fields(group) if "setting" in f.metadata
    }


def check_settings(group: Any) -> None:
    """Refuse values outside their range; call it from ``__post_init__``.

    Raises:
        SettingError: a value is invalid; the message names the setting and what is valid.
    """
    for name, known in describe(group).items():
        value = getattr(group, name)
        if known.choices and value not in known.choices:
            raise SettingError(f"{name} is {value!r}; valid are {', '.join(known.choices)}")
        if isinstance(value, (int, float)) and not known.low <= value <= known.high:
            unit = f" {known.unit}" if known.unit else ""
            raise SettingError(
                f"{name} is {number_text(value)}{unit}; valid is {_range(known)}{unit}"
            )


def check_names(group: Any, names: Iterable[str], path: str = "") -> None:
    """Refuse names that are not fields of a dataclass.

    Raises:
        SettingError: a name is unknown; the message gives it with its path, and the valid names.
    """
    valid = [f.name for f in dataclasses.fields(group)]
    for name in names:
        if name not in valid:
            raise SettingError(f"{path}{name} is unknown; valid are {', '.join(sorted(valid))}")


def _range(known: Setting) -> str:
    if math.isinf(known.high):
        return f"{number_text(known.low)} or more"
    if math.isinf(known.low):
        return f"{number_text(known.high)} or less"
    return f"{number_text(known.low)} to {number_text(known.high)}"


def as_float(value: float) -> float:
    """Return a number as a float; a whole number beyond all floats is infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def number_text(value: float) -> str:
    """Return a number as it was written: whole numbers with all their digits, if they are few."""
    if isinstance(value, int) and value.bit_length() <= 64:
        return str(value)
    try:
        whole = float(value).is_integer() and abs(value) < 1e15
        return f"{value:.0f}" if whole else f"{value:g}"
    except OverflowError:
        return "a very large number"
