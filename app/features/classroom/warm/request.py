"""CopyRequest: what a hub asks of the warm parent, and the socket by which it asks."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from robot.errors import BrickPoseError

READY_S = 240.0
"""Time for the warm parent to be warm [s]: it imports everything, and steps two robots; where what
is compiled cannot be kept it compiles, too, for a minute or two. One that ends is not waited for.
Half or twice of it changes for how long nobody is told of one that hangs."""
ANSWER_S = 10.0
LONGEST = 1 << 20
ENDED = "BRICKPOSE_CLASS_ENDED"
"""In the environment of a copy: why the one before it was ended, in words."""
SMALL = {
    "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1",
    "MALLOC_MMAP_THRESHOLD_": str(1 << 18), "MALLOC_TRIM_THRESHOLD_": str(1 << 20),
}  # fmt: skip
"""Threads of libraries would not be in a copy; and glibc gives each thread a heap of its own. By
itself it keeps the room of arrays that were freed, up to 32 MB each, for the next: a server that
has started then has 42 to 60 MB of its own, and 42 each time with pages of the system for arrays
from 256 kB on; with 1 MB 47."""


class WarmParentError(BrickPoseError, OSError):
    """There is no warm parent, or it makes no copy."""


@dataclass(frozen=True)
class Confinement:
    """What a copy is held to."""

    class_folder: str
    """It sees nothing of this but its own folder."""
    home: str
    number: int
    """The student's number in the hub; as root, each has a user of the system's of this number."""
    memory: int
    """Most memory of its processes together, and of each [bytes]; 0 is no limit."""
    own_port: int
    """The TCP port that it listens on."""
    hub_port: int
    """The only other one that it reaches."""
    disk: int = 0
    """Most room of its folder on the disk [bytes]; 0 is no limit."""


@dataclass(frozen=True)
class CopyRequest:
    """A server that is to be begun."""

    words: Sequence[str]
    """Of the command line, after ``brickpose``."""
    environment: Mapping[str, str]
    folder: str
    confinement: Confinement
    died: bool = False
    """The one before has ended, and nobody had asked for that."""

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> CopyRequest:
        """Return the request of JSON values."""
        return cls(**{**values, "confinement": Confinement(**values["confinement"])})


def ask(place: Path, request: CopyRequest) -> int:
    """Have a copy begun; return its process.

    Raises:
        WarmParentError: there is no warm parent, or it makes none.
    """
    try:
        with _connected(place) as asking:
            asking.sendall(json.dumps(request.to_json()).encode() + b"\n")
            with asking.makefile("rb") as answers:
                answer = json.loads(answers.readline(LONGEST) or b"{}")
    except (OSError, ValueError) as error:
        raise WarmParentError(f"the warm process does not answer: {error}") from error
    if "pid" not in answer:
        raise WarmParentError(f"the warm process makes no copy: {answer.get('error', 'it ended')}")
    return int(answer["pid"])


def start_parent(place: Path) -> None:
    """Start the warm parent that listens at a place, unless there is one; wait until it is warm.

    Raises:
        WarmParentError: it does not start.
    """
    if sys.platform != "linux":
        raise WarmParentError("copies of a warm process are for Linux")
    import fcntl  # noqa: PLC0415 - other systems have none

    if _answers(place):
        return
    # Thirty students may ask at once when it has died, and it takes a second of both cores.
    with place.with_suffix(".lock").open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not _answers(place):
            _start_parent(place)


def _start_parent(place: Path) -> None:
    log = place.with_suffix(".log")
    with log.open("ab") as out:
        process = subprocess.Popen(
            [sys.executable, "-m", "app.features.classroom.warm.parent", str(place)],
            stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True,
            env=os.environ | SMALL,
        )  # fmt: skip
    end = time.monotonic() + READY_S
    while not _answers(place):
        if process.poll() is not None or time.monotonic() > end:
            raise WarmParentError(f"the warm process does not start; {log} says why")
        time.sleep(0.05)


def _answers(place: Path) -> bool:
    try:
        _connected(place).close()
    except OSError:
        return False
    return True


def _connected(place: Path) -> socket.socket:
    asking = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    asking.settimeout(ANSWER_S)
    try:
        asking.connect(str(place))
    except OSError:
        asking.close()
        raise
    return asking
