"""``brickpose replay``: serves a recording, or writes its trajectories."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from app.console import say
from app.engine.plugging import plug_in
from app.feature_search import Features
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.library import NAME, listed
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.features.recordings.replay.requests import FASTEST, SLOWEST
from app.page.access_options import ACCESS_OPTIONS, announce, front_of, tokens_of
from app.page.first_start import compiled
from app.page.listening import listen
from app.page.serving import serve, serve_on
from app.result_files import make_folder
from app.settings.config import Config
from app.trajectories.trajectory import Trajectory
from app.trajectories.tum_file import write_tum
from robot.geometry import Array, Pose2
from robot.settings import SettingError

ONLY_SERVED = ("host", "port", "speed", "paused", *ACCESS_OPTIONS)
"""Options that have no effect without a dashboard."""


def run(given: dict[str, Any], features: Features) -> int:
    """Run the command with its options by name; return 0.

    Args:
        given: the options.
        features: what takes part.

    Raises:
        RecordingError, SettingError, FieldError, SpecError, OSError: says what cannot be used.
    """
    plug_in(features)
    path = recording_path(given.pop("file"))
    out: Path | None = given.pop("out", None)
    _check(given, out)
    access = {name: given.pop(name) for name in ACCESS_OPTIONS if name in given}
    options = ReplayOptions(**given)
    if out is not None:
        return _write(path, options, out)
    front = front_of(access)
    with listen(options.host, options.port) as listening:
        tokens = tokens_of(access, listening)
        ready = partial(announce, listening, tokens, front.scheme)
        port = listening.getsockname()[1]
        config = Config(host=options.host, port=port)
        with compiled(config, listening, tokens, front, ready) as start:
            if start is None:
                return 0
            program = open_replay(path, options)
            say(f"{path.name} is {program.replay.duration_s:.1f} s long")
            following = serve(program, start[0], tokens, front, start[1])
    if following is not None:
        serve_on(following, port, tokens, front)
    return 0


def recording_path(given: Path) -> Path:
    """Return where a recording is: a path, or the name of one that the page recorded.

    Raises:
        RecordingError: it is neither; says where it was looked for.
    """
    folder = Config().recording.path()
    if given.exists() or not NAME.fullmatch(given.name):
        return given
    for name in (given.name, given.name.removesuffix(".mcap").removesuffix("_0")):
        if given.parent == Path() and (folder / name).is_dir():
            return folder / name
    known = ", ".join(item.name for item in listed(folder)[:5]) or "none yet"
    raise RecordingError(
        f"there is no recording {given}; looked in {given.absolute().parent} and, for what "
        f"the page recorded, in {folder}, which has {known}"
    )


def _check(given: dict[str, Any], out: Path | None) -> None:
    """Refuse options that are out of range, or that have no effect with ``--out``.

    Raises:
        SettingError: names the option, and what is valid.
    """
    speed = given.get("speed", 1.0)
    if not SLOWEST <= speed <= FASTEST:
        raise SettingError(f"--speed is {speed:g}; valid is {SLOWEST:g} to {FASTEST:g}")
    if given.get("seed", 0) not in range(2**32):
        raise SettingError(f"--seed is {given['seed']}; valid is 0 to {2**32 - 1}")
    if given.get("port", 0) not in range(65536):
        raise SettingError(f"--port is {given['port']}; valid is 0 to 65535")
    for name in ONLY_SERVED:
        if out is not None and name in given:
            raise SettingError(f"--{name.replace('_', '-')} has no effect with --out")


def _write(path: Path, options: ReplayOptions, out: Path) -> int:
    given = _progress if sys.stderr.isatty() else None
    replayed = replay(path, options, given)
    if given is not None:
        sys.stderr.write("\r      \r")
    written = write(replayed, out, f"run: {path.name} of {replayed.stamps[-1]:.3f} s")
    for words in replayed.remarks:
        say(words)
    say(f"{', '.join(item.name for item in written)} are in {out}")
    return 0


def _progress(share: float) -> None:
    sys.stderr.write(f"\r{100 * share:3.0f} %")
    sys.stderr.flush()


@dataclass(frozen=True, eq=False)
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
    remarks: tuple[str, ...] = ()
    """What is missing in the recording, or not as it was recorded."""

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
    arrays = [np.array([_row(item) for item in kind]) for kind in poses]
    missing = (f"In the recording, {words}." for words in timeline.robot.reader.damages)
    remarks = tuple(dict.fromkeys((*program.remarks, *missing)))
    return Replayed(np.array(stamps), arrays[0], arrays[1], arrays[2], arrays[3], remarks)


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
