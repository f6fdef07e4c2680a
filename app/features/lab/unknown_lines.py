"""Writes what a calibration has measured, as lines of text."""

from __future__ import annotations

from collections.abc import Collection

from robot.description.unknowns import ROBOT, UNKNOWNS
from robot.geometry import Array


def unknown_lines(values: Array, sd: Array, not_learnt: Collection[str] = ()) -> list[str]:
    """Return a line for each unknown of the robot, with its interval.

    Args:
        values: (n,) differences from the description, in the order of ``UNKNOWNS``.
        sd: (n,) standard deviations of the values.
        not_learnt: names of the unknowns that the drive could not determine.
    """
    lines = [f"{'measured':<18}{'difference':>11}{'95 %':>10}"]
    for unknown, difference, each in zip(UNKNOWNS[: ROBOT + 1], values, sd, strict=False):
        value, spread = unknown.scale * difference, unknown.scale * each
        note = "  not learnt: this drive does not tell" if unknown.name in not_learnt else ""
        lines.append(
            f"{unknown.name:<18}{value:>+11.3f}{1.96 * spread:>10.3f} {unknown.unit}{note}"
        )
    return lines
