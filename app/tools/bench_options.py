"""``brickpose bench``: starts the benchmarks of a checkout as a process of their own."""

from __future__ import annotations

import argparse
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.command_parser import CommandParser
from app.interruption import deferred
from app.settings.config import ROOT
from robot.settings import SettingError

LOOK_S = 0.2
"""Interval of checking whether a signal asks to end [s]."""

BESIDE: dict[str, Any] = (
    {"creationflags": 0x200} if sys.platform == "win32" else {"start_new_session": True}
)
"""Options of a process that Ctrl-C on the terminal does not reach; on Windows, a new group's flag.
"""

PATIENCE_S = 10.0
"""Time that a benchmark has to end [s]."""


def add_bench(bench: CommandParser) -> None:
    """Add the options of ``bench``."""
    bench.argument_default = None
    bench.add_argument(
        "names", nargs="*", metavar="NAME", help="which (default: all that are quick)"
    )
    bench.add_argument("--json", type=Path, metavar="FILE", help="write the figures here too")
    bench.add_argument(
        "--minutes",
        type=float,
        metavar="N",
        help="how long the soak test runs, a minute at least (default: 10)",
    )
    bench.set_defaults(command=_bench)


def _bench(parsed: argparse.Namespace) -> int:
    # Benchmarks exist only in a checkout: the program does not import them.
    if not (ROOT / "benchmarks").is_dir():
        raise SettingError("benchmarks are only in a checkout of the sources, not in the wheel")
    written = [] if parsed.json is None else ["--json", str(parsed.json.absolute())]
    minutes = [] if parsed.minutes is None else ["--minutes", str(parsed.minutes)]
    command = [sys.executable, "-m", "benchmarks", *parsed.names, *written, *minutes]
    # Ctrl-C reaches it by this program alone.
    with deferred() as asked:
        child = subprocess.Popen(command, cwd=ROOT, **BESIDE)
        try:
            while child.poll() is None and not asked():
                with suppress(subprocess.TimeoutExpired):
                    child.wait(LOOK_S)
        finally:
            _end(child)
    return child.returncode


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a process that may have ended already, within a bounded time."""
    child.terminate()
    try:
        child.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()
