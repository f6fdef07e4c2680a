"""Read a trajectory from a file of any known format, which is recognized by the content."""

from __future__ import annotations

from pathlib import Path

from app.lab.trajectories.files.motive import is_motive, parse_motive
from app.lab.trajectories.files.mrclam import content_of, parse_mrclam
from app.lab.trajectories.files.named_columns import header_of, parse_named
from app.lab.trajectories.files.text_file import number_from, numbered, read_text
from app.lab.trajectories.files.tum import COLUMNS, parse_tum
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError

VALID = (
    f"TUM text ({COLUMNS}), the CSV of OptiTrack's Motive (begins with Format Version), "
    "MRCLAM text with its comments, a table with a header (stamp,x,y,z,q_w,q_x,q_y,q_z)"
)


def read_trajectory(path: Path | str, body: str | None = None) -> Trajectory:
    """Read a file of TUM or MRCLAM text, of Motive or EuRoC; it may be compressed by gzip.

    Args:
        path: of the file.
        body: which rigid body of a Motive file; needed if it has several.

    Raises:
        TrajectoryError: the file cannot be read or is not a trajectory; names file and line.
    """
    return parse_trajectory(read_text(Path(path)), str(path), body)


def parse_trajectory(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the text of a file; as in `read_trajectory`."""
    if is_motive(text):
        return parse_motive(text, source, body)
    if body is not None:
        raise TrajectoryError(f"{source}: only files of Motive have a rigid body {body!r}")
    if content_of(text) is not None:
        return parse_mrclam(text, source)
    header = header_of(text)
    if header is not None:
        return parse_named(text, source, header)
    _check_numeric(text, source)
    return parse_tum(text, source)


def _check_numeric(text: str, source: str) -> None:
    """Refuse a text of no known format: its first row does not begin with a number."""
    for line, row in numbered(text):
        if row.startswith("#"):
            continue
        try:
            number_from((row.replace(",", " ").split() or [""])[0])
        except ValueError as error:
            raise TrajectoryError(f"{source}, line {line}: {error}; valid are {VALID}") from error
        return
    raise TrajectoryError(f"{source} has no poses; valid are {VALID}")
