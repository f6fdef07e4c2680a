"""The table of a sweep, as CSV or Parquet."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from app.files import atomic_file
from robot.settings import SettingError

FORMATS = ("csv", "parquet")


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
