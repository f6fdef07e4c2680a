"""A robot's profile: what calibrations have measured of one robot, as a TOML file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from robot.description.lens_table import MeasuredLens, lens_of_table, table_lines
from robot.description.spec import RobotSpec
from robot.description.unknowns import NAMES, PRIORS, ROBOT, UNKNOWNS, Differences, with_named
from robot.description.urdf import SpecError
from robot.geometry import Array
from robot.settings import SettingError, as_float, number_text
from robot.toml_file import parse_toml, read_toml

NEVER = datetime(1970, 1, 1, tzinfo=UTC)
"""When a robot was measured of which nothing is known."""
SOLVER_UNITS = {"degree": "rad", "mm": "m", "ms": "s", "%": "relative"}
"""Units in the file, by those in which people read the numbers."""
MOST_SD = 10.0
"""Values farther off than this many standard deviations of a robot built by hand are refused."""


@dataclass(frozen=True, eq=False)
class Profile:
    """How one robot differs from its description."""

    robot: str
    """Name of the robot in its description."""
    made: datetime
    source: str
    """What it was measured from."""
    values: Array = field(repr=False)
    """(11,) differences from the description, in the order of ``UNKNOWNS``."""
    sd: Array = field(repr=False)
    """(11,) their standard deviations."""
    lens: MeasuredLens | None = None
    """The lens, if it was measured; the focal length's difference is one from it."""
    fit: Mapping[str, Any] = field(default_factory=dict, repr=False)
    """How well what was measured last fits (``FitQuality.table``)."""

    @classmethod
    def unmeasured(cls, robot: str, source: str) -> Profile:
        """Return the profile of a robot of which nothing is known yet."""
        return cls(robot, NEVER, source, np.zeros(ROBOT), PRIORS[:ROBOT].copy())

    @classmethod
    def of(cls, built: RobotSpec) -> Profile:
        """Return the profile that corrected a description."""
        nothing = cls.unmeasured(built.name, "")
        return profile_of(parse_toml(built.profile, "the profile")) if built.profile else nothing

    def changed(
        self,
        values: Mapping[str, float],
        sd: Mapping[str, float],
        made: datetime | None,
        source: str,
    ) -> Profile:
        """Return the profile with some values measured anew, by the unknowns' names.

        What has no standard deviation gets that of a robot built by hand.
        """
        every_sd = {name: sd.get(name, PRIORS[NAMES.index(name)]) for name in values}
        new, new_sd = with_named(self.values, values), with_named(self.sd, every_sd)
        return replace(self, made=made or self.made, source=source, values=new, sd=new_sd)

    def applied_to(self, spec: RobotSpec) -> RobotSpec:
        """Return the description of the built robot.

        Raises:
            SpecError: the profile is of another robot, or its lens is for other pictures.
        """
        if spec.name != self.robot:
            raise SpecError(f"the profile is of the robot {self.robot!r}, not of {spec.name!r}")
        built = Differences(self.values).applied_to(self.with_lens(spec))
        built = replace(built, profile=self.to_toml(), drawing=spec.as_drawn)  # with its own lens
        if self.made == NEVER:
            return replace(built, measured="", measured_sd=None)
        measured = f"{self.made:%Y-%m-%d}, {self.source or 'nobody knows from what'}"
        return replace(built, measured=measured, measured_sd=self.sd)

    def with_lens(self, spec: RobotSpec) -> RobotSpec:
        """Return a description with the profile's lens, if it has one, and else as it is.

        Raises:
            SpecError: the lens is for pictures of another size.
        """
        return spec if self.lens is None else self.lens.applied_to(spec)

    def to_toml(self) -> str:
        """Return the content of the file."""
        lines = [
            f"robot = {_quoted(self.robot)}",
            f"made = {self.made.astimezone(UTC).isoformat(timespec='seconds')}",
            f"source = {_quoted(self.source)}",
        ]
        for unknown, value, sd in zip(UNKNOWNS[:ROBOT], self.values, self.sd, strict=True):
            lines += [
                "",
                f"[{unknown.name}]  # {unknown.scale * value:.3f} "
                f"+- {1.96 * unknown.scale * sd:.3f} {unknown.unit} (95 %)",
                f"value = {float(value)!r}  # {SOLVER_UNITS[unknown.unit]}",
                f"sd = {float(sd)!r}",
            ]
        lines += ["", "[fit]", *(f"{k} = {json.dumps(v)}" for k, v in self.fit.items())]
        lines += table_lines(self.lens) if self.lens else []
        return "\n".join(lines) + "\n"


def load_profile(path: Path) -> Profile:
    """Read a profile.

    Raises:
        SpecError: the file cannot be read, or a value is missing or impossible; names it.
    """
    try:
        return profile_of(read_toml(path))
    except SettingError as error:
        raise SpecError(str(error)) from error
    except SpecError as error:
        raise SpecError(f"{path}: {error}") from error


def profile_of(content: dict[str, Any]) -> Profile:
    """Return the profile of the tables of a TOML file.

    Raises:
        SpecError: a value is missing, unknown or impossible; names it and what is valid.
    """
    for name in content:
        if name not in ("robot", "made", "source", "lens", "fit", *NAMES[:ROBOT]):
            raise SpecError(f"there is no {name}; valid are {', '.join(NAMES[:ROBOT])}, lens")
    robot, made, fit = content.get("robot"), content.get("made"), content.get("fit", {})
    if not isinstance(robot, str):
        raise SpecError("robot is missing: the name of the robot, a text")
    if not isinstance(made, datetime):
        raise SpecError("made is missing: when it was measured, a date with time")
    values, sd = np.zeros(ROBOT), np.zeros(ROBOT)
    for place, name in enumerate(NAMES[:ROBOT]):
        table = content.get(name)
        if not isinstance(table, dict):
            raise SpecError(f"[{name}] is missing: a table with value and sd")
        most = MOST_SD * PRIORS[place]
        values[place] = _number(table, name, "value", -most, most)
        sd[place] = _number(table, name, "sd", 0.0, most)
    lens = lens_of_table(content["lens"]) if "lens" in content else None
    return Profile(robot, made, str(content.get("source", "")), values, sd, lens, fit)


def check_values(values: Mapping[str, float], sd: Mapping[str, float]) -> None:
    """Refuse differences that no robot has, and standard deviations of no value.

    Raises:
        SpecError: a name is unknown, or a value impossible; names what is valid.
    """
    for key, least, numbers in (("value", -MOST_SD, values), ("sd", 0.0, sd)):
        for name, number in numbers.items():
            if name not in NAMES[:ROBOT]:
                raise SpecError(f"there is no {name}; valid are {', '.join(NAMES[:ROBOT])}")
            prior = PRIORS[NAMES.index(name)]
            _number({key: number}, name, key, least * prior, MOST_SD * prior)


def _number(table: dict[str, Any], name: str, key: str, low: float, high: float) -> float:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SpecError(f"{name}.{key} is {value!r}; valid is a number")
    number = as_float(value)
    if not low <= number <= high:
        raise SpecError(f"{name}.{key} is {number_text(value)}; valid is {low:g} to {high:g}")
    return number


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
