"""Reads a trajectory of any kind; files of the TUM RGB-D benchmark are read here."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from app.features.lab.trajectories.doubtful_stamps import doubt_of_stamps
from app.features.lab.trajectories.echoed import is_echoed, parse_echoed
from app.features.lab.trajectories.motive import is_motive, parse_motive
from app.features.lab.trajectories.mrclam import content_of, parse_mrclam
from app.features.lab.trajectories.named_columns import header_of, parse_named
from app.features.lab.trajectories.pose_graph import is_pose_graph, parse_pose_graph
from app.features.lab.trajectories.qualisys import is_qualisys, parse_qualisys
from app.features.lab.trajectories.rotation_matrices import quaternions_of
from app.features.lab.trajectories.text_file import (
    comments,
    number_from,
    numbered,
    read_text,
    rows_of_numbers,
    with_points,
)
from app.features.lab.trajectories.unstamped import TIMES, UNDERSTOOD, stamps_of
from app.features.lab.trajectories.vicon import is_vicon, parse_vicon
from app.trajectories.trajectory import LATEST, Trajectory, TrajectoryError
from app.trajectories.tum_file import COLUMNS

UNITS = {"nanoseconds": (1e16, 1e9), "microseconds": (1e14, 1e6), "milliseconds": (LATEST, 1e3)}
"""From which stamp on all are in a unit, as no date is so late in the next larger one; and how many
are a second."""
KITTI_COLUMNS = "r11 r12 r13 x r21 r22 r23 y r31 r32 r33 z"
CAPTURES = (
    (is_motive, parse_motive),
    (is_vicon, parse_vicon),
    (is_qualisys, parse_qualisys),
)
"""Files of motion capture, which may have several bodies: how to know and how to read them."""
VALID = (
    f"TUM text ({COLUMNS}), KITTI's poses ({KITTI_COLUMNS}), "
    "the CSV of OptiTrack's Motive (begins with Format Version) or of Vicon (Objects, Segments), "
    "the TSV of Qualisys's 6D data, g2o's VERTEX_SE2 and VERTEX_SE3:QUAT, "
    "MRCLAM text with its comments, what `ros2 topic echo --csv` prints, a table with a header "
    "(stamp,x,y,z,q_w,q_x,q_y,q_z; on a floor stamp,x,y,yaw)"
)


def parse_tum(text: str, source: str) -> Trajectory:
    """Read the text of a file; several poses may have the same stamp and all count, as in evo.

    Stamps that are all too late for seconds are milli-, micro- or nanoseconds; a note says so.
    """
    lines, rows = rows_of_numbers(text, source, COLUMNS)
    values = np.array(rows, dtype=np.float64).reshape(-1, 8)
    notes, stamps = comments(text), values[:, 0]
    for unit, (first, of_a_second) in UNITS.items():
        if len(stamps) and (stamps >= first).all():
            stamps = stamps / of_a_second
            notes += (f"{UNDERSTOOD} the stamps of {source} are {unit}",)
            break
    return Trajectory.of_rows(stamps, values[:, 1:4], values[:, 4:], source, notes, lines)


def is_kitti(text: str) -> bool:
    """Whether the first row of numbers is a pose of KITTI: twelve numbers."""
    rows = (row for _, row in numbered(text) if not row.startswith("#"))
    return len(next(rows, "").replace(",", " ").split()) == len(KITTI_COLUMNS.split())


def parse_kitti(text: str, source: str, times: str | None = None) -> Trajectory:
    """Read poses of KITTI's odometry benchmark: rows of a 3 x 4 matrix, world from body.

    Axes are taken as they are. Poses have no stamps.

    Args:
        times: as in `stamps_of`.

    Raises:
        TrajectoryError: a row is no pose, or there is another number of stamps.
    """
    lines, rows = rows_of_numbers(text, source, KITTI_COLUMNS)
    matrices = np.array(rows, dtype=np.float64).reshape(-1, 3, 4)
    quaternions = quaternions_of(matrices[:, :, :3], lines, source, KITTI_COLUMNS)
    stamps, notes = stamps_of(len(rows), source, times)
    notes = comments(text) + notes
    return Trajectory(stamps, matrices[:, :, 3], quaternions, source, notes, True, lines)


def read_trajectory(path: Path | str, body: str | None = None) -> Trajectory:
    """Read a file of text, also compressed by gzip: ``VALID`` says of which kinds.

    Args:
        body: which rigid body of a motion capture's file; needed if it has several.

    Raises:
        TrajectoryError: the file cannot be read or is not a trajectory; names file and line.
    """
    text, times = read_text(Path(path)), Path(path).parent / TIMES
    if body is None and times.is_file():
        if is_pose_graph(text):
            return parse_pose_graph(text, str(path), read_text(times))
        if is_kitti(text) and header_of(text) is None:
            return parse_kitti(text, str(path), read_text(times))
    return parse_trajectory(text, str(path), body)


def parse_trajectory(text: str, source: str, body: str | None = None) -> Trajectory:
    """Read the text of a file; as in `read_trajectory`."""
    return _doubted(_parsed(with_points(text), source, body))


def _doubted(trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with a note if its stamps are doubtful."""
    doubt = doubt_of_stamps(trajectory)
    notes = trajectory.notes if doubt is None else (*trajectory.notes, f"{UNDERSTOOD} {doubt}")
    return replace(trajectory, notes=notes, lines=None)


def _parsed(text: str, source: str, body: str | None) -> Trajectory:
    for is_captured, parse in CAPTURES:
        if is_captured(text):
            return parse(text, source, body)
    if body is not None:
        raise TrajectoryError(
            f"{source}: only files of Motive, Vicon and Qualisys have a rigid body {body!r}"
        )
    if is_pose_graph(text):
        return parse_pose_graph(text, source)
    if content_of(text) is not None:
        return parse_mrclam(text, source)
    header = header_of(text)
    if header is not None:
        return parse_named(text, source, header)
    if is_echoed(text):
        return parse_echoed(text, source)
    return _of_numbers(text, source)


def _of_numbers(text: str, source: str) -> Trajectory:
    _check_numeric(text, source)
    return parse_kitti(text, source) if is_kitti(text) else parse_tum(text, source)


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
