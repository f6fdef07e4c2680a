"""What a student's processes take together: who takes too much is ended or slowed, nobody else."""

from __future__ import annotations

import os
import resource
import signal
import sys
import time
from contextlib import suppress

import pytest
from camera_sources import until

from app.features.classroom.warm import watch as watching
from app.features.classroom.warm.request import Confinement
from app.features.classroom.warm.watch import FIRST_USER, ClassWatch, of_server, processes, size_of

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
MB = 1 << 20
BOMB = 40
"""Children that a fork bomb of these tests begins at most; the system would refuse more than 60."""


class _Class:
    """Students of this test's own, each a process that a test gives something to do."""

    def __init__(self, folder):
        self.folder = folder
        self.watch = ClassWatch()
        self.pids: list[int] = []

    def begin(self, number: int, work, **limits: int) -> Confinement:
        home = self.folder / f"student-{number}"
        home.mkdir(exist_ok=True)
        held = Confinement(str(self.folder), str(home), number, limits.get("memory", 0), 1, 2,
                           limits.get("disk", 0))  # fmt: skip
        pid = os.fork()
        if not pid:
            with suppress(BaseException):
                os.setsid()
                if os.geteuid() == 0:
                    os.setresuid(*(FIRST_USER + number,) * 3)
                    resource.setrlimit(resource.RLIMIT_NPROC, (60, 60))
                resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
                work()
            os._exit(0)
        self.pids.append(pid)
        self.watch.begin(pid, held)
        return held

    def alive(self, place: int) -> bool:
        pid = self.pids[place]
        return os.waitpid(pid, os.WNOHANG)[0] == 0 if pid else False

    def close(self):
        user = FIRST_USER if os.geteuid() == 0 else None
        seen = processes()
        for number, pid in enumerate(self.pids):
            for each in of_server(pid, None if user is None else user + number, seen):
                with suppress(ProcessLookupError):
                    os.kill(each.pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(pid, 0)


@pytest.fixture
def students(tmp_path):
    made = _Class(tmp_path)
    yield made
    made.close()


def sleeps() -> None:
    time.sleep(30)


def test_memory_of_several_processes_is_counted_together(students):
    read, write = os.pipe()

    def several() -> None:
        for _ in range(2):
            if not os.fork():
                kept = bytearray(b"x" * (60 * MB))
                os.write(write, b"x")
                time.sleep(30)
                del kept
        time.sleep(30)

    greedy = students.begin(0, several)
    students.begin(1, sleeps)

    def taken() -> int:
        """Memory of all three [bytes], with their share of what they have from this test."""
        own = of_server(students.pids[0], None, processes())
        return sum(watching._memory(each.pid) for each in own)

    for _ in range(2):
        assert os.read(read, 1)
    os.close(read)
    os.close(write)

    def look(most: int) -> None:
        held = Confinement(greedy.class_folder, greedy.home, 0, most, 1, 2)
        students.watch.begin(students.pids[0], held)
        students.watch.look()

    most = taken()
    look(most + 40 * MB)
    assert students.alive(0), "each has less, and all together have"
    look(most - 20 * MB)
    assert not students.alive(0)
    assert students.alive(1)
    assert f"MB of memory; valid is {(most - 20 * MB) >> 20}" in students.watch.ended[greedy.home]
    assert not of_server(students.pids[0], None, processes())


def test_a_fork_bomb_ends_with_all_its_children(students, monkeypatch):
    monkeypatch.setattr(watching, "MOST_THREADS", 20)

    def bomb() -> None:
        for _ in range(BOMB):
            with suppress(OSError):
                if not os.fork():
                    os.setsid()
                    time.sleep(30)
        time.sleep(30)

    held = students.begin(0, bomb)
    students.begin(1, sleeps)
    until(lambda: len(of_server(students.pids[0], None, processes())) > 30)
    students.watch.look()
    user = FIRST_USER if os.geteuid() == 0 else None
    assert not of_server(students.pids[0], user, processes())
    assert "processes and threads; valid are 20" in students.watch.ended[held.home]
    assert not students.alive(0)
    assert students.alive(1)


def test_an_endless_loop_gets_what_others_leave_and_comes_back(students, monkeypatch):
    if os.geteuid() != 0:
        pytest.skip("without root nobody comes forward again")
    monkeypatch.setattr(watching, "BUSY_SHARE", 0.02)
    monkeypatch.setattr(watching, "BUSY_S", 0.0)
    busy = students.folder / "student-0" / "busy"

    def loop() -> None:
        while busy.exists():
            pass
        time.sleep(30)

    busy.parent.mkdir()
    busy.touch()
    students.folder.chmod(0o755)
    for above in students.folder.parents:
        if above.name.startswith(("pytest-", "popen-")):
            above.chmod(0o755)
    students.begin(0, loop)
    students.begin(1, sleeps)

    def place(number: int) -> int:
        students.watch.look()
        return os.getpriority(os.PRIO_PROCESS, students.pids[number])

    until(lambda: place(0) == watching.LAST)
    assert place(1) != watching.LAST
    busy.unlink()
    until(lambda: place(0) == watching.USUAL)
    assert students.alive(0)
    assert not students.watch.ended


def test_a_full_folder_ends_its_own_student_who_then_writes_short_files_alone(students):
    full = students.begin(0, sleeps, disk=2 * MB)
    students.begin(1, sleeps, disk=2 * MB)
    long = students.folder / "student-0" / "long"
    long.write_bytes(b"x" * (3 * MB))
    for _ in range(2):  # one folder a look
        students.watch.look()
    assert not students.alive(0)
    assert students.alive(1)
    assert "your folder has 3 MB; valid is 2" in students.watch.ended[full.home]
    assert students.watch.longest_file(full, 9 * MB) == MB

    students.begin(0, sleeps, disk=2 * MB)
    for _ in range(2):
        students.watch.look()
    assert students.alive(2), "who has been told may go on, and remove something"
    long.unlink()
    for _ in range(2):
        students.watch.look()
    assert students.watch.longest_file(full, 9 * MB) == 9 * MB


def test_many_files_are_too_many_and_links_lead_nowhere(tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "file").write_bytes(b"x" * MB)
    (tmp_path / "out").symlink_to("/usr")
    assert MB <= size_of(tmp_path) < 2 * MB
    monkeypatch.setattr(watching, "MOST_ENTRIES", 2)
    assert size_of(tmp_path) > 1 << 50


def test_a_reason_is_told_until_a_server_has_lived_that_was_told(students, monkeypatch):
    """The second server may die of the same code before its student reads why the first did."""
    monkeypatch.setattr(watching, "MOST_THREADS", 0)
    held = students.begin(0, sleeps)
    students.watch.look()
    assert not students.alive(0)
    told = students.watch.ended[held.home]
    monkeypatch.undo()
    for _ in range(2):
        students.watch.clear(held, died=True)
        assert students.watch.ended[held.home] == told
    students.begin(0, sleeps)
    students.watch.look()
    assert students.watch.ended[held.home] == told
    monkeypatch.setattr(watching, "TOLD_S", 0.0)
    students.watch.look()
    assert held.home not in students.watch.ended
    assert students.alive(1)


def test_who_ends_before_somebody_looks_is_told_too(students, monkeypatch):
    held = students.begin(0, lambda: None)
    until(lambda: not students.alive(0))
    students.watch.clear(held, died=False)
    assert not students.watch.ended, "its student ended it"
    students.watch.clear(held, died=True)
    assert students.watch.ended[held.home] == watching.BY_ITSELF
    if os.geteuid() != 0:
        return  # without root, children of who has ended are nobody's

    def leaves() -> None:
        if not os.fork():
            time.sleep(30)

    students.begin(0, leaves)
    monkeypatch.setattr(watching, "MOST_THREADS", 0)
    until(lambda: not students.alive(1))
    students.watch.clear(held, died=True)
    assert "1 processes and threads; valid are 0" in students.watch.ended[held.home]


def test_what_an_earlier_server_has_left_ends_before_the_next_begins(students):
    if os.geteuid() != 0:
        pytest.skip("without root, students share a user")

    def leaves() -> None:
        if not os.fork():
            os.setsid()
            time.sleep(30)

    held = students.begin(0, leaves)
    until(lambda: not students.alive(0))
    assert of_server(0, FIRST_USER, processes())
    students.watch.clear(held)
    assert not of_server(0, FIRST_USER, processes())
