"""Replay a recording through the filter as fast as possible, without a viewer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.files import make_folder
from app.lab.trajectories.files.tum import write_tum
from app.lab.trajectories.trajectory import Trajectory
from app.recordings.replay.opening import ReplayOptions, open_replay
from robot.geometry import Array, Pose2


@dataclass(frozen=True)
class Replayed:
    """Poses of the robot at the ticks of a recording, on the recording's clock."""

    stamps: Array
    """(n,) of all ticks [s]."""
    estimated: Array
    """(n, 3) by the filter that runs now [m, m, rad]; nan before the first estimate."""
    recorded_estimate: Array
    """(n, 3) by the filter that ran during the recording; nan where the recording has none."""
    truth: Array
    """(n, 3) nan where it is not known."""
    odometry: Array
    """(n, 3) by the wheels alone, in the map, from where the robot began."""

    def trajectories(self) -> dict[str, Trajectory]:
        """Return the trajectories with at least two poses, by name."""
        arrays = {
            "estimated": self.estimated,
            "then": self.recorded_estimate,
            "truth": self.truth,
            "odometry": self.odometry,
        }
        result = {}
        for name, poses in arrays.items():
            known = ~np.isnan(poses[:, 0])
            if np.count_nonzero(known) >= 2:
                result[name] = Trajectory.of_poses(self.stamps[known], poses[known], name)
        return result


def replay(
    path: Path,
    options: ReplayOptions = ReplayOptions(),
    given: Callable[[float], None] | None = None,
) -> Replayed:
    """Run the filter on a recording; the same file, options and seed give the same result.

    Args:
        path: of the recording.
        options: what differs from the recorded run.
        given: called every 500 ticks with the share that is done.

    Raises:
        RecordingError, SettingError, FieldError, SpecError: as ``open_replay``.
    """
    program = open_replay(path, options)
    replayed = program.replay
    timeline = replayed.timeline
    rows: list[tuple[float, Pose2 | None, Pose2 | None, Pose2 | None, Pose2]] = []
    try:
        while timeline.robot.next_ns is not None:
            each = timeline.tick()
            rows.append(
                (each.stamp, each.pose, timeline.estimate_then(each), each.truth, each.odometry)
            )
            if given is not None and len(rows) % 500 == 0:
                given(min(each.stamp / max(replayed.duration_s, 1e-9), 1.0))
    finally:
        program.robot.close()
    stamps, *poses = zip(*rows, strict=True)
    return Replayed(np.array(stamps), *(np.array([_row(item) for item in kind]) for kind in poses))


def write(replayed: Replayed, folder: Path, note: str) -> list[Path]:
    """Write ``estimated.tum``, ``then.tum``, ``truth.tum`` and ``odometry.tum``, if known.

    Raises:
        SettingError, OSError: the folder cannot be written to.
    """
    make_folder(folder)
    written = []
    for name, trajectory in replayed.trajectories().items():
        path = folder / f"{name}.tum"
        write_tum(path, trajectory, (note,))
        written.append(path)
    return written


def _row(pose: Pose2 | None) -> Array:
    return np.full(3, np.nan) if pose is None else pose.to_array()
