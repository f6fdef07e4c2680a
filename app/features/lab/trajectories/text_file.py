"""Read a text file of numbers, with a clear message for every fault."""

from __future__ import annotations

import gzip
import re
import zlib
from collections.abc import Sequence
from pathlib import Path

from app.features.recordings.files.file_kinds import other_kind
from app.trajectories.trajectory import TrajectoryError

LARGEST = 2**28
"""A larger file is not a trajectory [bytes]."""
GZIP, ZIP = b"\x1f\x8b", b"PK\x03\x04"
DECIMAL_COMMA = re.compile(r"[-+]?\d*(,\d+)?([eE][-+]?\d+)?|[-+]?nan|", re.IGNORECASE)
"""A number with a decimal comma, or a whole one."""


def read_text(path: Path) -> str:
    """Return the text of a file, which may be compressed by gzip, with "\\n" between lines.

    Raises:
        TrajectoryError: the file is missing, a folder, empty, too large or not text.
    """
    data = _read_bytes(path)
    if len(data) > LARGEST:
        raise TrajectoryError(f"{path} is larger than {LARGEST >> 20} MB; no trajectory is")
    kind = other_kind(data)
    if kind is not None and not data.startswith(ZIP):
        raise TrajectoryError(f"{path} is {kind}; valid is text, a pose a line")
    if data.startswith(ZIP):
        raise TrajectoryError(
            f"{path} is a zip archive or a spreadsheet (.xlsx, .ods); valid is text: unpack it, or "
            "save it as CSV"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise TrajectoryError(f"{path}, line {line}: not UTF-8 text") from error
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise TrajectoryError(f"{path}, line {line}: not text but binary data")
    if not text.strip():
        raise TrajectoryError(f"{path} is empty; valid is a pose a line")
    return text


def _read_bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            if file.peek(2)[:2] != GZIP:
                return file.read(LARGEST + 1)
            with gzip.GzipFile(fileobj=file) as unpacked:
                return unpacked.read(LARGEST + 1)
    except FileNotFoundError as error:
        raise TrajectoryError(f"there is no file {path}") from error
    except IsADirectoryError as error:
        raise TrajectoryError(f"{path} is a folder; valid is a file") from error
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise TrajectoryError(f"{path} is damaged: its gzip data ends or breaks off") from error
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL
        raise TrajectoryError(f"{path} cannot be read: {error}") from error


def numbered(text: str) -> list[tuple[int, str]]:
    """Return the lines that are not blank, with their numbers, which start at 1."""
    stripped = ((number, line.strip()) for number, line in enumerate(text.split("\n"), 1))
    return [(number, line) for number, line in stripped if line]


def comments(text: str) -> tuple[str, ...]:
    """Return the texts of the lines that begin with "#"."""
    return tuple(line.lstrip("#").strip() for _, line in numbered(text) if line.startswith("#"))


def with_points(text: str) -> str:
    """Return a table with commas between cells and decimal points.

    Spreadsheets of many countries write ``1,5;2,5``, and programs with such settings ``1,5 2,5``.
    """
    rows = (row for _, row in numbered(text) if row[0] in "+-.0123456789")
    first = next(rows, "")
    by_semicolons = ";" in first
    cells = first.split(";") if by_semicolons else first.split()
    decimal_commas = "," in first and all(DECIMAL_COMMA.fullmatch(cell.strip()) for cell in cells)
    if not (by_semicolons or (decimal_commas and len(cells) > 1)):
        return text
    lines = text.split("\n")
    if decimal_commas:
        lines = [line if line.lstrip()[:1] == "#" else line.replace(",", ".") for line in lines]
    return "\n".join(lines).replace(";", ",") if by_semicolons else "\n".join(lines)


def rows_of_numbers(text: str, source: str, columns: str) -> tuple[list[int], list[list[float]]]:
    """Return line numbers (n,) and numbers (n, k) of a table with "#" comments.

    Spaces, tabs or commas separate the numbers.

    Args:
        columns: names of the k columns, separated by spaces.

    Raises:
        TrajectoryError: a row has another number of columns, or a cell is not a number.
    """
    lines, rows, expected = [], [], len(columns.split())
    for number, line in numbered(text):
        if line.startswith("#"):
            continue
        cells = line.replace(",", " ").split()
        if len(cells) != expected:
            raise TrajectoryError(
                f"{source}, line {number}: {len(cells)} columns; valid are {expected}: {columns}"
            )
        rows.append(as_numbers(cells, source, number))
        lines.append(number)
    return lines, rows


def as_numbers(cells: Sequence[str], source: str, line: int) -> list[float]:
    """Return the cells of one line as numbers; NaN and infinities are accepted.

    Raises:
        TrajectoryError: a cell is not a number.
    """
    try:
        return [number_from(cell) for cell in cells]
    except ValueError as error:
        raise TrajectoryError(f"{source}, line {line}: {error}") from error


def number_from(cell: str) -> float:
    """Parse a number; Python's underscores are refused, as other programs do not write them.

    Raises:
        ValueError: the cell is not a number.
    """
    try:
        if "_" in cell:
            raise ValueError
        return float(cell)
    except ValueError:
        raise ValueError(f"{cell[:40]!r} is no number") from None
