"""Stress test: workers and programs are ended at random moments; all end soon, nothing is left."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.settings.config import ROOT
from benchmarks.result import Result

STARTS = 10
"""Workers that each program starts."""
LONGEST_WAIT_S = 3.0
"""Longest time that the last workers work before the program is told to end [s]."""
BOUND_S = 5.0
"""Time in which everything has ended [s]."""


@dataclass
class Ends:
    """What was seen."""

    workers: list[float] = field(default_factory=list)
    """Times until a worker that its program ended was gone, and its jobs told [s]."""
    programs: list[float] = field(default_factory=list)
    """Times from SIGTERM until a program and all its workers were gone [s]."""
    kinds: Counter[str] = field(default_factory=Counter)
    """Workers by what they worked on."""
    working: int = 0
    """Workers that had done a job already, and were at another."""
    wrong: list[str] = field(default_factory=list)
    """What was not as it should be."""


def measure(count: int = 200) -> Result:
    """Start and end workers, and tell how long the ends took.

    Raises:
        RuntimeError: something was left, or did not end in time.
    """
    seen = ends(count)
    if seen.wrong:
        raise RuntimeError("; ".join(seen.wrong))
    return Result(
        unit="s from SIGTERM until all had ended, worst",
        brickpose=max(seen.programs),
        more={
            "workers started and ended": sum(seen.kinds.values()),
            "programs ended": len(seen.programs),
            "worker ended by its program, worst [s]": max(seen.workers, default=0.0),
            "workers that had done a job before": seen.working,
            **{f"workers at: {kind}": number for kind, number in sorted(seen.kinds.items())},
        },
    )


def ends(count: int, seed: int = 0) -> Ends:
    """Start so many workers in several programs, and end all."""
    seen, chance = Ends(), random.Random(seed)
    left = count
    while left > 0:
        starts = min(STARTS, left)
        _one_program(starts, seed + count - left, chance.uniform(0.0, LONGEST_WAIT_S), seen)
        left -= starts
        ended, done = sum(seen.kinds.values()), seen.working
        worst = max(seen.workers, default=0.0), max(seen.programs, default=0.0)
        sys.stdout.write(
            f"{ended} workers ended, {done} after a job; worst {worst[0]:.2f} s, "
            f"of programs {worst[1]:.2f} s; wrong: {len(seen.wrong)}\n"
        )
        sys.stdout.flush()
    return seen


def _one_program(starts: int, seed: int, wait: float, seen: Ends) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        with subprocess.Popen(
            [sys.executable, "-m", "benchmarks.ended_program", f"{seed}", f"{starts}"],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=os.environ | {"TMPDIR": temporary},
        ) as program:
            try:
                _note_workers(program, seen)
                time.sleep(wait)
                began = time.monotonic()
                program.send_signal(signal.SIGTERM)
                _, complaint = program.communicate(timeout=BOUND_S)
                while (alive := of_session(program.pid)) and time.monotonic() < began + BOUND_S:
                    time.sleep(0.001)
                seen.programs.append(time.monotonic() - began)
                if alive:
                    seen.wrong.append(f"{len(alive)} processes were left")
                if (program.returncode, complaint) != (128 + signal.SIGTERM, ""):
                    seen.wrong.append(f"ended with {program.returncode}: {complaint}")
            except subprocess.TimeoutExpired:
                seen.wrong.append(f"seed {seed}: the program did not end within {BOUND_S:g} s")
            finally:
                with suppress(ProcessLookupError):
                    os.killpg(program.pid, signal.SIGKILL)
        seen.wrong += [f"{path.name} was left" for path in Path(temporary).iterdir()]


def _note_workers(program: subprocess.Popen[str], seen: Ends) -> None:
    """Read what a program tells of its workers, until it waits for the signal."""
    assert program.stdout is not None
    for line in program.stdout:
        event: dict[str, Any] = json.loads(line)
        if "alive" in event:
            seen.kinds.update(event["alive"])
            return
        if "seconds" in event:
            seen.kinds[event["kind"]] += 1
            seen.workers.append(event["seconds"])
            seen.working += event["done"] > 0
            if event["left"] or event["untold"] or event["failures"] or event["seconds"] > BOUND_S:
                seen.wrong.append(f"a worker's end: {event}")
    seen.wrong.append("the program ended by itself")


def of_session(session: int) -> list[int]:
    """Return the processes of a session that still run."""
    pids = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = path.read_text().rpartition(")")[2].split()
            if int(fields[3]) == session and fields[0] != "Z":
                pids.append(int(path.parent.name))
    return pids
