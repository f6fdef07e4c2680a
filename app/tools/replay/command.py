"""``brickpose replay``: serves a recording, or writes its trajectories."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from app.console import say
from app.lab.replay_trajectories import replay, write
from app.page.access_options import ACCESS_OPTIONS, announce, certificate_of, tokens_of
from app.page.serving import listen, serve
from app.recordings.replay.opening import ReplayOptions, open_replay
from app.recordings.replay.requests import FASTEST, SLOWEST
from robot.settings import SettingError

ONLY_SERVED = ("host", "port", "speed", "paused", *ACCESS_OPTIONS)
"""Options that have no effect without a dashboard."""


def run(given: dict[str, Any]) -> int:
    """Run the command with its options by name; return 0.

    Raises:
        RecordingError, SettingError, FieldError, SpecError, OSError: says what cannot be used.
    """
    path: Path = given.pop("file")
    out: Path | None = given.pop("out", None)
    _check(given, out)
    access = {name: given.pop(name) for name in ACCESS_OPTIONS if name in given}
    options = ReplayOptions(**given)
    if out is not None:
        return _write(path, options, out)
    certificate = certificate_of(access)
    with listen(options.host, options.port) as listening:
        tokens = tokens_of(access, listening)
        program = open_replay(path, options)
        say(f"{path.name} is {program.replay.duration_s:.1f} s long")
        announce(listening, tokens, "https" if certificate else "http")
        serve(program, listening, tokens, certificate)
    return 0


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
    say(f"{', '.join(item.name for item in written)} are in {out}")
    return 0


def _progress(share: float) -> None:
    sys.stderr.write(f"\r{100 * share:3.0f} %")
    sys.stderr.flush()
