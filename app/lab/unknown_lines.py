"""Tells people what was measured of a robot."""

from __future__ import annotations

from collections.abc import Collection

from robot.calibration.unknowns import ROBOT, UNKNOWNS
from robot.geometry import Array


def unknown_lines(values: Array, sd: Array, not_learnt: Collection[str] = ()) -> list[str]:
    """Return the robot's unknowns (at least 12) with their intervals, a line each, for people."""
    lines = [f"{'measured':<18}{'difference':>11}{'95 %':>10}"]
    for place, unknown in enumerate(UNKNOWNS[: ROBOT + 1]):
        value, spread = unknown.scale * values[place], unknown.scale * sd[place]
        note = "  not learnt: this drive does not tell" if unknown.name in not_learnt else ""
        lines.append(
            f"{unknown.name:<18}{value:>+11.3f}{1.96 * spread:>10.3f} {unknown.unit}{note}"
        )
    return lines
