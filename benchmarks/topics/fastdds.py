"""A peer on another vendor's DDS, eProsima's Fast DDS; it reads and writes the bytes of any topic.

Its source is tests/fastdds_peer; the library is Debian's package libfastrtps-dev.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from app.features.ros.dds.protocol import dds_topic, dds_type
from app.features.ros.topics import TOPICS
from app.settings.config import ROOT

SOURCES = ROOT / "tests" / "fastdds_peer"
HEADER = Path("/usr/include/fastdds/dds/domain/DomainParticipant.hpp")
ANSWER_S = 20.0
END_S = 5.0

Event = list[str]
"""The words of one line of output; peer.cpp lists the possible lines."""


def missing() -> str | None:
    """Return what is missing for a peer; None if nothing is."""
    if shutil.which("g++") is None:
        return "no C++ compiler (g++)"
    if not HEADER.exists():
        return "no Fast DDS (sudo apt-get install libfastrtps-dev)"
    return None


def built() -> Path:
    """Return the peer's program; compile it if it does not exist yet.

    Raises:
        subprocess.CalledProcessError: the program cannot be compiled.
    """
    text = b"".join(path.read_bytes() for path in sorted(SOURCES.iterdir()))
    made = Path(sys.prefix) / "peers" / f"fastdds_{hashlib.sha256(text).hexdigest()[:12]}"
    if not made.exists():
        made.parent.mkdir(exist_ok=True)
        part = made.with_suffix(f".{os.getpid()}")  # other processes may compile it, too
        source = str(SOURCES / "peer.cpp")
        libraries = ("-lfastrtps", "-lfastcdr")
        subprocess.run(
            ["g++", "-std=c++17", "-O1", source, "-o", str(part), *libraries], check=True
        )
        part.replace(made)
    return made


class Peer:
    """One participant, in a process of its own; its events are kept and can be waited for."""

    def __init__(self, domain: int) -> None:
        self.events: list[Event] = []
        self._arrival = threading.Condition()
        self._process = subprocess.Popen(
            [str(built()), str(domain)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        # Always read its output: a full pipe would stop it.
        self._listening = threading.Thread(target=self._listen, name="peer")
        self._listening.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """The id of its process."""
        return self._process.pid

    def read(
        self,
        topic: str,
        type_name: str,
        *,
        reliable: bool = True,
        latched: bool = False,
        lengths: bool = False,
    ) -> None:
        """Subscribe to a DDS name with a ROS 2 type; events hold the bytes or only their number."""
        form = "lengths" if lengths else "bytes"
        self._say("read", topic, dds_type(type_name), *_quality(reliable, latched), form)

    def write(
        self, topic: str, type_name: str, *, reliable: bool = True, latched: bool = False
    ) -> None:
        """Create a writer for a topic."""
        self._say("write", topic, dds_type(type_name), *_quality(reliable, latched))

    def send(self, topic: str, data: bytes) -> None:
        """Publish bytes."""
        self._say("send", topic, data.hex())

    def wait(
        self,
        kind: str,
        name: str = "",
        condition: Callable[[Event], object] = bool,
        after: int = 0,
        seconds: float = ANSWER_S,
    ) -> Event:
        """Wait for the first event of a kind, for a topic or GUID, that fulfils a condition.

        Raises:
            TimeoutError: there is no such event in time; lists the last events.
        """
        end = time.monotonic() + seconds
        seen = after
        with self._arrival:
            while time.monotonic() < end:
                for event in self.events[seen:]:
                    if event[0] == kind and name in ("", event[1]) and condition(event):
                        return event
                seen = len(self.events)
                self._arrival.wait(end - time.monotonic())
        last = [" ".join(event)[:100] for event in self.events[-20:]]
        raise TimeoutError(f"no {kind} {name} in {seconds:g} s; it told {last}")

    def data(self, topic: str, after: int = 0, seconds: float = ANSWER_S) -> bytes:
        """Wait for the first message of a topic and return its bytes."""
        return bytes.fromhex(self.wait("data", topic, after=after, seconds=seconds)[3])

    def read_live_topics(self) -> None:
        """Subscribe to all topics of a live robot; events have only the number of bytes."""
        for topic in TOPICS:
            if topic.live:
                latched = topic.quality.latched
                self.read(dds_topic(f"/{topic.name}"), topic.type, latched=latched, lengths=True)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(END_S)
        finally:
            self._process.kill()
            self._process.wait()
            self._listening.join()
            assert self._process.stdout is not None
            self._process.stdout.close()

    def _say(self, *words: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(" ".join(words) + "\n")
        self._process.stdin.flush()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._arrival:
                self.events.append(line.split())
                self._arrival.notify_all()


def _quality(reliable: bool, latched: bool) -> tuple[str, str]:
    return (
        "reliable" if reliable else "best_effort",
        "transient_local" if latched else "volatile",
    )
