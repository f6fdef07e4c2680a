"""What tape looks like, which kinds a picture is searched for, and what was found of one kind."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array


@dataclass(frozen=True, slots=True)
class Tape:
    """One kind of tape on a floor."""

    width: float
    """[m]"""
    light: bool = False
    """Whether it is lighter than the floor around it."""
    dash: float = 0.0
    """Length of a dash [m]; 0 if the tape has no gaps."""


BLACK_TAPE = Tape(0.050)
"""The tape of a floor that is not described otherwise."""


BRIGHTNESS = ("field", "dark", "light", "either")
"""Valid ``tape_brightness``."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Kinds of tape that are all darker, or all lighter, than the floor."""

    light: bool
    widths: Array
    """(n,) of tape without gaps [m]."""
    dashes: Array
    """(m, 2) width and length of dashes [m]."""

    @property
    def all_widths(self) -> list[float]:
        """Widths of tape with and without gaps [m]."""
        return [*self.widths.tolist(), *self.dashes[:, 0].tolist()]


def looks(brightness: str, width: float, tape: tuple[Tape, ...]) -> tuple[Look, ...]:
    """Return what is searched for: dark tape, light tape, or both one after the other.

    Args:
        brightness: one of ``BRIGHTNESS``; all but ``field`` overrule the kinds of tape.
        width: of all tape [m]; 0 is as wide as each kind is.
        tape: the kinds of tape on the field; without any, black tape is searched for.
    """
    kinds = tape or (BLACK_TAPE,)
    if width:
        kinds = tuple(replace(kind, width=width) for kind in kinds)
    shades = {
        "field": sorted({kind.light for kind in kinds}),
        "dark": [False],
        "light": [True],
        "either": [False, True],
    }[brightness]
    return tuple(
        _look(light, [kind for kind in kinds if brightness != "field" or kind.light == light])
        for light in shades
    )


def _look(light: bool, kinds: list[Tape]) -> Look:
    solid = sorted({kind.width for kind in kinds if not kind.dash})
    dashed = sorted({(kind.width, kind.dash) for kind in kinds if kind.dash})
    return Look(light, np.array(solid), np.array(dashed).reshape(-1, 2))


def nearest_widths(measured: Array, counted: NDArray[np.bool_], known: Array) -> Array:
    """Return which width (k,) of those of tape (n,) is nearest to each that was measured (k,) [m].

    It is nan where a reading does not count.
    """
    places = np.abs(np.nan_to_num(measured)[:, None] - known).argmin(axis=1)
    return np.where(counted, known[places], np.nan)


class FoundTape(NamedTuple):
    """What was found in one picture of dark tape, or of light tape, or of both."""

    edges: Array
    """(k, 2) entry and exit of the chosen pair [samples]."""
    verdicts: NDArray[np.int8]
    """(k,) the ``Verdict`` of each ray."""
    widths: Array
    """(k,) [m]; nan without a line."""
    lines: Array
    """(k, 3) unit normal and offset [m] of the entry edges; nan without a line."""
    ranges: Array
    """(k,) by the entries' lines [m], inf for rays that do not count."""
    hidden: Array
    """(k, 2) from where to where something that is no tape lies on the ray [m], ``Scan.hidden``."""
    first: Array
    """(k, 2) where a ray first meets the edge of anything, and leaves it [samples]; nan without."""
    noise: float
    """Of the picture [grey levels]."""
    kernel: int
    """Half width of the edge kernel [samples]."""
    clear: Array
    """(k,) probability that tape on a ray is found."""

    def nearer(self, other: FoundTape) -> FoundTape:
        """Return what counts of either, on each ray the nearer one."""
        # Where neither counts, the verdict is of the one that came closest to counting.
        closer = other.verdicts > self.verdicts
        counted = np.isfinite(self.ranges) | np.isfinite(other.ranges)
        taken = np.where(counted, other.ranges < self.ranges, closer)
        # What is tape to the one is a thing to the other.
        hull = np.column_stack(
            [
                np.minimum(self.hidden[:, 0], other.hidden[:, 0]),
                np.maximum(self.hidden[:, 1], other.hidden[:, 1]),
            ]
        )
        sooner = ~(self.first[:, 0] <= other.first[:, 0]) & ~np.isnan(other.first[:, 0])
        return FoundTape(
            np.where(taken[:, None], other.edges, self.edges),
            np.where(taken, other.verdicts, self.verdicts),
            np.where(taken, other.widths, self.widths),
            np.where(taken[:, None], other.lines, self.lines),
            np.where(taken, other.ranges, self.ranges),
            np.where(counted[:, None], np.where(taken[:, None], other.hidden, self.hidden), hull),
            np.where(sooner[:, None], other.first, self.first),
            self.noise,
            self.kernel,
            np.minimum(self.clear, other.clear),
        )
