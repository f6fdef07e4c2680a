"""The lens in a robot's profile: the table ``[lens]`` of a TOML file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robot.camera import CameraError, Lens
from robot.description.spec import RobotSpec
from robot.description.urdf import SpecError
from robot.distortion import COEFFICIENTS
from robot.geometry import Array
from robot.settings import as_float, number_text

LARGEST = 1e6
"""No lens has a larger number."""


@dataclass(frozen=True, eq=False)
class MeasuredLens:
    """A lens with its uncertainty."""

    lens: Lens = field(repr=False)
    sd: Array = field(repr=False)
    """(p,) standard deviations in the order of ``Lens.parameters``; nan if unknown."""

    @classmethod
    def of(cls, lens: Lens, sd: Array | None = None) -> MeasuredLens:
        """Return a lens whose standard deviations may not be known."""
        return cls(lens, np.full(len(lens.parameters), np.nan) if sd is None else sd)

    def applied_to(self, spec: RobotSpec) -> RobotSpec:
        """Return a robot's description with this lens; the readout time stays the same.

        Raises:
            SpecError: the lens is for pictures of another size.
        """
        lens, described = self.lens, spec.lens
        if (lens.width, lens.height) != (described.width, described.height):
            raise SpecError(
                f"the profile's lens is for pictures of {lens.width} x {lens.height} px; the "
                f"robot's are of {described.width} x {described.height} px: calibrate it at that "
                "size"
            )
        return replace(spec, lens=replace(lens, readout=described.readout))


def table_lines(measured: MeasuredLens) -> list[str]:
    """Return the lines of the table."""
    lens = measured.lens
    lines = [
        "",
        f"[lens]  # as ROS's camera_info has it, for pictures of {lens.width} x {lens.height} px",
        f"width = {lens.width}",
        f"height = {lens.height}",
        f'model = "{lens.model}"',
    ]
    if lens.matrix[0, 1]:
        lines.append(f"skew = {float(lens.matrix[0, 1])!r}")
    for (name, value), sd in zip(lens.parameters.items(), measured.sd.tolist(), strict=True):
        lines.append(f"{name} = {value!r}")
        if math.isfinite(sd):
            lines.append(f"{name}_sd = {sd!r}")
    return lines


def lens_of_table(table: Any) -> MeasuredLens:
    """Return the lens of a table.

    Raises:
        SpecError: a value is missing, unknown or impossible; names it and what is valid.
    """
    if not isinstance(table, dict):
        raise SpecError("lens is no table; valid is [lens] with width, height, model, fx, ...")
    model = table.get("model")
    if model not in COEFFICIENTS:
        raise SpecError(f"lens.model is {model!r}; valid are {', '.join(COEFFICIENTS)}")
    names = ("fx", "fy", "cx", "cy", *COEFFICIENTS[model])
    known = {"width", "height", "model", "skew", *names, *(f"{name}_sd" for name in names)}
    for name in table:
        if name not in known:
            raise SpecError(f"there is no lens.{name}; valid are {', '.join(sorted(known))}")
    fx, fy, cx, cy, *rest = (_number(table, name) for name in names)
    sd = [_number(table, f"{name}_sd") if f"{name}_sd" in table else math.nan for name in names]
    skew = _number(table, "skew") if "skew" in table else 0.0
    try:
        lens = Lens(
            _whole(table, "width"),
            _whole(table, "height"),
            np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]]),
            np.array(rest),
            model=model,
        )
    except CameraError as error:
        raise SpecError(f"lens: {error}") from error
    return MeasuredLens(lens, np.array(sd))


def _number(table: dict[str, Any], name: str) -> float:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SpecError(f"lens.{name} is {value!r}; valid is a number")
    number = as_float(value)
    if not abs(number) <= LARGEST:
        raise SpecError(f"lens.{name} is {number_text(value)}; valid is up to {LARGEST:g}")
    return number


def _whole(table: dict[str, Any], name: str) -> int:
    value = table.get(name)
    if isinstance(value, bool) or not isinstance(value, int):
        raise SpecError(f"lens.{name} is {value!r}; valid is a whole number")
    return value
