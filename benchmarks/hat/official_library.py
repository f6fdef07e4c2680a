"""Check that Raspberry Pi's own library, unmodified, works on the emulated Build HAT."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from app.settings.config import ROOT
from benchmarks.hat.emulated_hat import EmulatedHat, emulated_hat
from benchmarks.hat.official_session import PARTS
from benchmarks.result import Result

STARTS = 50
OTHER_FIRMWARE = 1670596313
"""A firmware version of 2022."""
SESSION_TIMEOUT = 90.0
"""[s]; the library waits 11 s after an upload of 5 s, and forever if something is lost."""

VALID: dict[str, tuple[float, float]] = {
    "hat.vin": (7.9, 8.1),
    "get.aposition": (-180, 179),
    "get.speed": (-1, 1),
    "seconds.forth.turned": (90, 500),
    "seconds.forth.seconds": (0.95, 1.5),
    "seconds.back.turned": (-500, -10),
    "seconds.queued.seconds": (0, 0.2),
    "seconds.done.seconds": (0.45, 1.0),
    "degrees.forth.turned": (345, 370),
    "degrees.back.turned": (-190, -165),
    "degrees.rotations.turned": (-370, -345),
    "position.shortest": (-15, 15),
    "position.clockwise": (-15, 15),
    "position.anticlockwise": (-15, 15),
    "callback.count": (50, 200),
    "callback.span": (335, 370),
    "callback.turned": (345, 370),
    "callback.marks": (1, 1),
    "pwm.limit 0.3": (120, 200),
    "pwm.limit 1": (450, 560),
    "pwm.back": (-560, -450),
    "pwm.float": (-5, 5),
    "pwm.coast": (-5, 5),
    "rpm.seconds.turned": (650, 950),
    "rpm.speed.speed": (340, 385),
    "rpm.degrees.turned": (165, 195),
    "pair.seconds": (0.95, 1.5),
    "pair.left, right.0": (90, 500),
    "pair.left, right.1": (-500, -90),
    "pair.degrees.0": (160, 195),
    "pair.degrees.1": (160, 195),
    "pair.off.0": (-15, 15),
    "pair.off.1": (-15, 15),
}
"""Valid findings of a session. The limits for the end of a move are wide: the library stops
controlling 0.2 s after the set-point has arrived, and its default speed control takes a second to
start."""


class SessionError(RuntimeError):
    """The library did not work as it should."""


def session(hat: EmulatedHat, *parts: str) -> dict[str, Any]:
    """Run a program with the library on the emulator's port, and return its findings.

    Raises:
        SessionError: the program hung or failed.
    """
    command = [sys.executable, "-m", "benchmarks.hat.official_session"]
    command += [str(hat.device), str(hat.control), *parts]
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=os.environ | {"GPIOZERO_PIN_FACTORY": "mock"},
            capture_output=True,
            text=True,
            timeout=SESSION_TIMEOUT,
            check=True,
        )
    except subprocess.TimeoutExpired as error:
        raise SessionError(f"the library hung; the board: {hat.ask('state')}") from error
    except subprocess.CalledProcessError as error:
        raise SessionError(f"the library failed: {error.stderr[-2000:]}") from error
    findings: dict[str, Any] = json.loads(done.stdout)
    return findings


def wrong(findings: dict[str, Any]) -> list[str]:
    """Return a message for each invalid finding of a session."""
    return [
        f"{name} is {value:g}; valid is {VALID[name][0]:g} to {VALID[name][1]:g}"
        for name, value in _flat(findings)
        if name in VALID and not VALID[name][0] <= value <= VALID[name][1]
    ]


def checked(findings: dict[str, Any]) -> int:
    """Return how many findings of a session are checked."""
    return sum(name in VALID for name, _ in _flat(findings))


def measure() -> Result:
    """Check every call, uploads and another firmware, and count how many of 50 starts work.

    Raises:
        SessionError: a call did not work as it should.
    """
    with tempfile.TemporaryDirectory() as folder:
        more = _calls(Path(folder)) | _uploads(Path(folder))
        worked, seconds, cpu = _starts(Path(folder))
    more |= {"time of a start [s]": seconds, "CPU of the emulator meanwhile [share]": cpu}
    return Result(unit=f"starts of {STARTS}", brickpose=worked, more=more)


def _calls(folder: Path) -> dict[str, float]:
    with emulated_hat(folder, "--world", "free") as hat:
        findings = session(hat, *PARTS)
    faults = wrong(findings)
    if faults:
        raise SessionError("; ".join(faults))
    return {"calls' effects as they should be": checked(findings)}


def _uploads(folder: Path) -> dict[str, float]:
    """Start from the bootloader, and from another firmware by the reset pin; then start again."""
    more = {}
    beginnings = {
        "bootloader": ("--bootloader",),
        "another firmware": ("--firmware", str(OTHER_FIRMWARE)),
    }
    for name, options in beginnings.items():
        with emulated_hat(folder, "--world", "free", *options) as hat:
            more[f"start from {name} [s]"] = session(hat, "hat", "get")["start"]
            more[f"start again after {name} [s]"] = session(hat, "hat", "get")["start"]
    return more


def _starts(folder: Path) -> tuple[int, float, float]:
    """Return how many starts worked, the longest time [s], and the emulator's share of a core."""
    times = []
    with emulated_hat(folder, "--world", "free") as hat:
        begin, used = time.monotonic(), hat.cpu_seconds()
        for _ in range(STARTS):
            times += list(_try_start(hat))
        share = (hat.cpu_seconds() - used) / (time.monotonic() - begin)
    return len(times), max(times, default=float("nan")), share


def _try_start(hat: EmulatedHat) -> Iterator[float]:
    try:
        findings = session(hat, "get")
    except SessionError as error:
        print(f"a start did not work: {error}", file=sys.stderr)
        return
    if not wrong(findings):
        yield findings["start"]


def _flat(node: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers with their paths."""
    if isinstance(node, dict | list):
        pairs = node.items() if isinstance(node, dict) else enumerate(node)
        for name, child in pairs:
            yield from _flat(child, f"{path}.{name}" if path else str(name))
    elif isinstance(node, int | float):
        yield path, node
