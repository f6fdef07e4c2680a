"""What a sweep writes: the table, as CSV or Parquet, and a plot of the error by each setting."""

from __future__ import annotations

import csv
import itertools
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from app.features.lab.report_page import GREY, OKABE_ITO, svg_figure
from app.files import atomic_file
from robot.settings import SettingError

FORMATS = ("csv", "parquet")
MEASURE, LABEL = "ate_rmse_m", "absolute error, rms [mm]"
OFFSET_MEASURE, OFFSET_LABEL = "steady_ate_rmse_m", "steady error, rms [mm]"
FEW = 12
"""Medians are drawn for at most this many values: more come from a random sample."""
WORD = 24
"""Longest text of a value; longer ones, such as paths of files, show only their end."""
MARKS = tuple(zip("o^sDvP*X", (*OKABE_ITO, GREY), strict=True))
"""Marks and colours of worlds and conditions; they repeat if there are more."""


class TableError(SettingError):
    """The table cannot be written in the requested format."""


def require_format(kind: str) -> None:
    """Refuse a format that cannot be written here, before hours of work.

    Raises:
        TableError: the format is unknown, or its library is missing; says how to get it.
    """
    if kind not in FORMATS:
        raise TableError(f"no format {kind!r}; valid are {', '.join(FORMATS)}")
    if kind == "parquet":
        try:
            import pyarrow  # noqa: F401, PLC0415 - an extra
        except ImportError as error:
            raise TableError("Parquet needs pyarrow: pip install 'brickpose[parquet]'") from error


def write_table(path: Path, rows: list[dict[str, Any]]) -> None:
    """Write rows, all with the same columns; the file is complete or unchanged.

    Raises:
        OSError: the file cannot be written.
    """
    with atomic_file(path) as new:
        if path.suffix == ".parquet":
            _write_parquet(new, rows)
        else:
            with new.open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(rows[0]))
                writer.writeheader()
                writer.writerows(rows)


def _write_parquet(path: Path, rows: list[dict[str, Any]]) -> None:
    import pyarrow  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    columns = {name: [row[name] for row in rows] for name in rows[0]}
    for name, values in columns.items():
        # A column has one type: if its values have several types, it becomes text.
        if len({_kind(value) for value in values if value is not None}) > 1:
            columns[name] = [str(value) for value in values]
    parquet.write_table(pyarrow.table(columns), path)


def _kind(value: Any) -> type:
    return float if type(value) is int else type(value)


def plot_setting(path: Path, setting: str, rows: list[dict[str, Any]], steady: bool) -> None:
    """Write an SVG of the error by one setting; its title counts the runs without an error.

    Args:
        steady: whether to show the error after the pose became right, for wrong start poses.

    Raises:
        OSError: the file cannot be written.
    """
    svg = _draw(setting, rows, steady)
    with atomic_file(path) as new:
        new.write_text(svg, encoding="utf-8")


@svg_figure(5.2, 3.2)
def _draw(figure: Figure, setting: str, rows: list[dict[str, Any]], steady: bool) -> None:
    measure, label = (OFFSET_MEASURE, OFFSET_LABEL) if steady else (MEASURE, LABEL)
    shown = [row for row in rows if row[measure] is not None]
    values = sorted({row[setting] for row in rows}, key=_order)
    words = not all(_is_number(value) for value in values)
    position = {value: index if words else value for index, value in enumerate(values)}
    axes = figure.add_subplot()
    worlds = list(dict.fromkeys(_where(row) for row in rows))
    for (mark, colour), world in zip(itertools.cycle(MARKS), worlds, strict=False):
        of_world = [row for row in shown if _where(row) == world]
        x = [position[row[setting]] for row in of_world]
        y = [1e3 * row[measure] for row in of_world]
        axes.plot(x, y, mark, color=colour, ms=4, alpha=0.5, label=world)
        if len(values) <= FEW and of_world:
            places = sorted(set(x))
            medians = [np.median([b for a, b in zip(x, y, strict=True) if a == p]) for p in places]
            axes.plot(places, medians, "-", color=colour, lw=1.5)
    failed = len(rows) - len(shown)
    given = f"{failed} runs failed or were never right" if failed else ""
    axes.set(
        xlabel=setting, ylabel=label, title=given,
        yscale="log" if shown else "linear",
    )  # fmt: skip
    if words:
        axes.set_xticks(range(len(values)), [_word(value) for value in values])
    elif _is_wide(values):
        axes.set_xscale("log")
    for axis in (axes.yaxis, axes.xaxis) if not words else (axes.yaxis,):
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)


def _where(row: dict[str, Any]) -> str:
    """Return the world, and the condition if it is not the default one."""
    usual = row["condition"] == "default"
    return str(row["world"]) if usual else f"{row['world']}, {row['condition']}"


def _word(value: Any) -> str:
    """Return a value as text, short enough to leave room for the figure."""
    text = str(value)
    return text if len(text) <= WORD else f"…{text[1 - WORD :]}"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _order(value: Any) -> tuple[bool, Any]:
    return (not _is_number(value), value if _is_number(value) else str(value))


def _is_wide(values: list[Any]) -> bool:
    """Whether values span so much that a logarithmic axis shows them better."""
    return bool(min(values) > 0 and max(values) / min(values) >= 20)
