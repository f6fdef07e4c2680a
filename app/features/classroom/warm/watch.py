"""ClassWatch: what each student's processes take together; who takes too much is slowed or ended.

The system limits single processes, and as root the number of a user's. Memory of several, the size
of a folder, and the processor's time of them together are nobody's limit there, so the warm parent,
whose children all of them are, looks at them every two seconds. It needs no cgroups, which a
container seldom may make.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from app.features.classroom.warm.request import Confinement

FIRST_USER = 1_800_000_000
"""Numbers of the system's users from here on belong to nobody; a student's number is added."""
LOOK_S = 2.0
"""Interval of looking [s]. A look at 60 processes takes 6 ms, 0.3 % of a core; in 2 s a process
that does nothing else writes some 2 GB, which ``RLIMIT_DATA`` forbids it."""
MOST_THREADS = 100
"""Processes and threads of a student; the program has some thirty, and as many for a grader."""
BUSY_SHARE, BUSY_S = 1.2, 10.0
"""Who took more than this share of a core for so long [s] gets what others leave, until less. A
robot that drives, with its page, takes 0.2; a grader or a map 1.0 for some seconds."""
LAST, USUAL = 19, 2
"""Places in the queue for the processor, as ``nice`` counts them."""
MOST_ENTRIES = 20_000
"""Files in a folder, of which more are too many: to count them would hold up all others."""
TIGHT_FILE = 1 << 20
"""Longest file of a student whose folder is full [bytes]: enough to save a program."""
TOLD_S = 60.0
"""A server that is told why the one before it was ended has told its student after this time [s].
One that ends earlier has perhaps told nobody: the next is told, too. Half or twice of it changes
for how long a server that was begun by a click says what was said before."""
BY_ITSELF = "your robot's program ended by itself"
ROUNDS = 50
ORPHANS = 1
"""The process that gets the children of those that have ended."""


@dataclass(frozen=True)
class SeenProcess:
    """A process as the system lists it."""

    pid: int
    parent: int
    user: int
    threads: int
    ticks: int
    """Processor time, of itself alone."""
    own_kb: int
    """What it does not read from files; shared pages count, too."""


@dataclass
class _Held:
    pid: int
    confinement: Confinement
    ticks: dict[int, int]
    stamp: float
    busy_since: float | None = None
    last: bool = False
    begun: float = field(default_factory=time.monotonic)


class ClassWatch:
    """Watches the servers that a warm parent has begun; one thread uses it."""

    def __init__(self) -> None:
        self._held: dict[str, _Held] = {}
        """By the student's folder."""
        self.ended: dict[str, str] = {}
        """Why a student's processes were ended, in words, by the student's folder; until a server
        has lived for ``TOLD_S`` that was told so."""
        self._next = 0
        """Whose folder is measured next; one a look."""
        self._full: set[str] = set()

    def begin(self, pid: int, confinement: Confinement) -> None:
        """Watch a server, in place of the one that its student had before."""
        self._held[confinement.home] = _Held(pid, confinement, {}, time.monotonic())

    def clear(self, confinement: Confinement, *, died: bool = False) -> None:
        """End what an earlier server of a student has left.

        Args:
            confinement: the student's.
            died: the earlier server has ended, and nobody had asked for that.
        """
        held = self._held.pop(confinement.home, None) or _Held(0, confinement, {}, 0.0)
        # Too many processes may end a server before somebody looks: it cannot begin its own.
        complaint = self._complaint(held, of_server(held.pid, _user_of(held), processes()))
        if complaint:
            self.ended[confinement.home] = complaint
        elif died:
            self.ended.setdefault(confinement.home, BY_ITSELF)
        self._end(held)

    def longest_file(self, confinement: Confinement, usual: int) -> int:
        """Return how long files of a student may be now [bytes]."""
        return TIGHT_FILE if confinement.home in self._full else usual

    def look(self) -> None:
        """Look at all once, and act."""
        seen = processes()
        for home, held in tuple(self._held.items()):
            own = of_server(held.pid, _user_of(held), seen)
            if not own:
                del self._held[home]
                continue
            if time.monotonic() - held.begun > TOLD_S:
                self.ended.pop(home, None)
            complaint = self._complaint(held, own)
            if complaint:
                self.ended[home] = complaint
                self._end(held)
            else:
                self._mind_processor(held, own)
        self._measure_a_folder()

    def _complaint(self, held: _Held, own: list[SeenProcess]) -> str:
        threads, most_threads = sum(each.threads for each in own), MOST_THREADS
        if threads > most_threads:
            return f"your programs had {threads} processes and threads; valid are {most_threads}"
        most = held.confinement.memory
        # The exact figure takes the system a while, so it is asked for only near the limit.
        if most and sum(each.own_kb for each in own) * 1024 > most:
            taken = sum(_memory(each.pid) for each in own)
            if taken > most:
                megabytes, valid = taken >> 20, most >> 20
                return f"your programs took {megabytes} MB of memory; valid is {valid}"
        return ""

    def _mind_processor(self, held: _Held, own: list[SeenProcess]) -> None:
        stamp = time.monotonic()
        spent = sum(each.ticks - held.ticks.get(each.pid, each.ticks) for each in own)
        share = spent / os.sysconf("SC_CLK_TCK") / max(stamp - held.stamp, 0.1)
        held.ticks, held.stamp = {each.pid: each.ticks for each in own}, stamp
        if share <= BUSY_SHARE:
            held.busy_since = None
        elif held.busy_since is None:
            held.busy_since = stamp
        last = held.busy_since is not None and stamp - held.busy_since >= BUSY_S
        if last or last != held.last:
            _queue(own, LAST if last else USUAL)
        held.last = last

    def _measure_a_folder(self) -> None:
        homes = sorted(self._held)
        if not homes:
            return
        self._next = (self._next + 1) % len(homes)
        held = self._held[homes[self._next]]
        home, most = held.confinement.home, held.confinement.disk
        size = size_of(Path(home))
        if not most or size <= most:
            self._full.discard(home)
        elif home not in self._full:
            self._full.add(home)
            megabytes, valid = size >> 20, most >> 20
            self.ended[home] = (
                f"your folder has {megabytes} MB; valid is {valid}: until you or your "
                "teacher remove something, files are at most 1 MB long"
            )
            self._end(held)

    def _end(self, held: _Held) -> None:
        """End all processes of a student, faster than they begin others."""
        for _ in range(ROUNDS):
            own = of_server(held.pid, _user_of(held), processes())
            if not own:
                return
            for sign in (signal.SIGSTOP, signal.SIGKILL):
                for each in own:
                    with suppress(OSError):
                        os.kill(each.pid, sign)
            time.sleep(0.01)


def _user_of(held: _Held) -> int | None:
    return FIRST_USER + held.confinement.number if os.geteuid() == 0 else None


def processes() -> dict[int, SeenProcess]:
    """Return all processes of the system that have not ended, by their numbers."""
    seen = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, LookupError, ValueError):
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            if fields[0] in "ZX":
                continue
            status = (folder / "status").read_text()
            rows = dict(line.split(":", 1) for line in status.splitlines())
            pid = int(folder.name)
            seen[pid] = SeenProcess(
                pid, int(fields[1]), int(rows["Uid"].split()[0]), int(fields[17]),
                int(fields[11]) + int(fields[12]), int(rows.get("RssAnon", "0").split()[0]),
            )  # fmt: skip
    return seen


def of_server(server: int, user: int | None, seen: dict[int, SeenProcess]) -> list[SeenProcess]:
    """Return a student's processes: the server, what descends from it, and its user's orphans.

    A server is a child of this process; another one may have its number by now. Another class on
    this machine may have students of the same numbers, below a warm parent of its own.
    """
    children: dict[int, list[int]] = {}
    for each in seen.values():
        children.setdefault(each.parent, []).append(each.pid)
    descendants = [server] if server in seen and seen[server].parent == os.getpid() else []
    for pid in descendants:
        descendants += children.get(pid, [])
    orphans = [
        each.pid
        for each in seen.values()
        if user is not None and each.user == user and each.parent == ORPHANS
    ]
    for pid in orphans:
        orphans += children.get(pid, [])
    return [seen[pid] for pid in dict.fromkeys((*descendants, *orphans))]


def size_of(folder: Path) -> int:
    """Return what a folder takes on the disk [bytes]; very much if nobody could count its files."""
    size = count = 0
    waiting = [folder]
    while waiting:
        with suppress(OSError), os.scandir(waiting.pop()) as entries:
            for entry in entries:
                count += 1
                if count > MOST_ENTRIES:
                    return 1 << 60
                with suppress(OSError):
                    if entry.is_dir(follow_symlinks=False):
                        waiting.append(Path(entry.path))
                    size += entry.stat(follow_symlinks=False).st_blocks * 512
    return size


def _memory(pid: int) -> int:
    """Return a process's share of the memory [bytes]: what several have is divided among them."""
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return 0
    [kilobytes] = [line.split()[1] for line in text.splitlines() if line.startswith("Pss:")]
    return int(kilobytes) * 1024


def _queue(own: Iterable[SeenProcess], place: int) -> None:
    for each in own:
        with suppress(OSError):
            for task in Path(f"/proc/{each.pid}/task").iterdir():
                with suppress(OSError):  # without root nobody comes forward again
                    os.setpriority(os.PRIO_PROCESS, int(task.name), place)
        # Where each session has a share of its own, places count in the session alone.
        with suppress(OSError):
            Path(f"/proc/{each.pid}/autogroup").write_text(str(place))
