"""A student's file asks the kernel itself: no file and no other process feels anything of it."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from course.solutions import ARRAYS, LOOPS

from app.features.course.grading import grade
from app.features.course.lesson import lessons
from app.features.course.sandbox.student_process import StudentProcess
from app.features.course.sandbox.system_calls import MACHINES

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or os.uname().machine not in MACHINES, reason="fences of Linux's kernel"
)
ARM = sys.platform == "linux" and os.uname().machine == "aarch64"
ARRAY = np.arange(3.0)
WORDS = "import ctypes, os, sys\nc = ctypes.CDLL(None, use_errno=True)\n"


def asked(body: str, source: str = WORDS) -> float:
    """What a function of a student's file returns."""
    lines = "".join(f"    {line}\n" for line in body.splitlines())
    with StudentProcess("mine.py", f"{source}def f(a):\n{lines}") as process:
        answer = process.call("f", (ARRAY,)).result
    assert isinstance(answer, float)
    return answer


@dataclass
class Victim:
    """A process of the same user, and a file; what could have been done to them."""

    process: subprocess.Popen[bytes]
    file: Path

    @property
    def state(self) -> tuple[object, ...]:
        """What an attack would change."""
        pid, held = self.process.pid, self.file.stat()
        limits = tuple(resource.prlimit(pid, limit) for limit in (resource.RLIMIT_NOFILE, 0, 7))
        status = Path(f"/proc/{pid}/status").read_text()
        kept = [
            line
            for line in status.splitlines()
            # Not SigQ: it counts the waiting signals of all of the user's processes.
            if line.startswith(("Name", "TracerPid", "Uid", "Sig", "Shd", "Cpus"))
            and not line.startswith("SigQ")
        ]
        return (
            self.process.poll(), limits, os.getpriority(os.PRIO_PROCESS, pid),
            os.sched_getaffinity(pid), os.sched_getscheduler(pid), os.getpgid(pid), *kept,
            held.st_mode, held.st_mtime, held.st_uid, self.file.read_bytes(),
            sorted(path.name for path in self.file.parent.iterdir()),
        )  # fmt: skip


@pytest.fixture
def victim(tmp_path: Path) -> Iterator[Victim]:
    file = tmp_path / "secret.txt"
    file.write_text("secret")
    file.chmod(0o600)
    os.utime(file, (1e9, 1e9))
    tmp_path.chmod(0o777)  # a folder that everybody may change
    process = subprocess.Popen([sys.executable, "-c", "print(flush=True); input()"],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
    assert process.stdout is not None
    process.stdout.readline()
    yield Victim(process, file)
    process.kill()
    process.communicate()


def number(name: str) -> int:
    return {
        "rt_sigqueueinfo": (129, 138), "rt_tgsigqueueinfo": (297, 240), "kill": (62, 129),
        "tkill": (200, 130), "tgkill": (234, 131), "pidfd_open": (434, 434),
        "pidfd_send_signal": (424, 424), "fchmodat2": (452, 452), "utimes": (235, -1),
        "utime": (132, -1), "futimesat": (261, -1), "utimensat": (280, 88),
        "setpriority": (141, 140), "prlimit64": (302, 261), "ptrace": (101, 117),
        "process_vm_readv": (310, 270), "process_vm_writev": (311, 271), "kcmp": (312, 272),
        "io_uring_setup": (425, 425), "keyctl": (250, 219), "add_key": (248, 217),
        "sched_setaffinity": (203, 122), "sched_setscheduler": (144, 119), "setpgid": (109, 154),
        "ioprio_set": (251, 30), "migrate_pages": (256, 238), "process_madvise": (440, 440),
        "get_robust_list": (274, 100), "perf_event_open": (298, 241), "fcntl": (72, 25),
        "prctl": (157, 167), "memfd_create": (319, 279), "userfaultfd": (323, 282),
        "open_by_handle_at": (304, 265), "mq_open": (240, 180), "chdir": (80, 49),
        "clone3": (435, 435), "openat2": (437, 437), "mount_setattr": (442, 442),
        "setuid": (105, 146), "capset": (126, 91), "quotactl": (179, 60), "acct": (163, 89),
        "syslog": (103, 116), "unlinkat": (263, 35), "swapon": (167, 224), "bpf": (321, 280),
    }[name][ARM]  # fmt: skip


CALLS = {
    "rt_sigqueueinfo": "{pid}, 9, info", "rt_tgsigqueueinfo": "{pid}, {pid}, 9, info",
    "kill": "{pid}, 9", "tkill": "{pid}, 9", "tgkill": "{pid}, {pid}, 9", "pidfd_open": "{pid}, 0",
    "fchmodat2": "-100, {file}, 0o777, 0", "utimes": "{file}, None", "utime": "{file}, None",
    "futimesat": "-100, {file}, None", "utimensat": "-100, {file}, None, 0",
    "setpriority": "0, {pid}, 10", "prlimit64": "{pid}, 7, limits, None",
    "ptrace": "16, {pid}, 0, 0",
    "process_vm_readv": "{pid}, 0, 0, 0, 0, 0", "process_vm_writev": "{pid}, 0, 0, 0, 0, 0",
    "kcmp": "{pid}, {pid}, 1, 0, 0", "io_uring_setup": "4, big", "keyctl": "0, -3, 1",
    "add_key": "b'user', b'a', b'b', 1, -3", "sched_setaffinity": "{pid}, 8, limits",
    "sched_setscheduler": "{pid}, 3, limits", "setpgid": "{pid}, {pid}",
    "ioprio_set": "1, {pid}, 7",
    "migrate_pages": "{pid}, 0, 0, 0", "get_robust_list": "{pid}, big, limits",
    "perf_event_open": "big, {pid}, -1, -1, 0", "prctl": "62, 1, {pid}, 0, 0",
    "memfd_create": "b'a', 0", "userfaultfd": "1", "open_by_handle_at": "-100, big, 0",
    "mq_open": "b'a', 0o102, 0o600, 0", "chdir": "b'/'", "clone3": "big, 88",
    "openat2": "-100, {file}, big, 24", "setuid": "0", "capset": "big, big", "syslog": "3, big, 9",
    "unlinkat": "-100, {file}, 0", "bpf": "0, big, 64",
}  # fmt: skip
"""Arguments of each call; each would do something to the victim, or out of the process."""
SETUP = """
info = (ctypes.c_int * 32)(); info[0] = 9; info[2] = -1
limits = (ctypes.c_uint64 * 4)(1, 1, 0, 0)
big = (ctypes.c_uint64 * 64)()
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", CALLS)
def test_a_call_by_its_number_is_not_there_and_nothing_happens(victim: Victim, name: str) -> None:
    if number(name) < 0:
        pytest.skip("this machine has no such call")
    before = victim.state
    arguments = CALLS[name].format(pid=victim.process.pid, file=repr(os.fsencode(victim.file)))
    called = f"r = c.syscall({number(name)}, {arguments})"
    body = f"{SETUP}{called}\nreturn float(r * ctypes.get_errno())"
    assert asked(body) == -38.0  # ENOSYS
    assert victim.state == before


WAYS = {
    "a pipe's owner gets signals": """import fcntl
fcntl.fcntl(0, 8, {pid}); fcntl.fcntl(0, 10, 9); fcntl.fcntl(0, 4, 0o20000 | 0o4000)""",
    "a signal by Python": "os.kill({pid}, 9)",
    "a signal to the group": "c.kill(0, 23)",
    "its memory": "f = open('/proc/{pid}/mem', 'r+b', 0)",
    "its memory by C": "assert c.open(b'/proc/{pid}/mem', 2) >= 0",
    "its letters": "open('/proc/{pid}/environ').read()",
    "its pages": "open('/proc/{pid}/maps').read()",
    "the file by name": "open({file!r}).read()",
    "the file by C": "assert c.open({file!r}.encode(), 0) >= 0",
    "the file by its place": "assert c.fchmod(c.open({file!r}.encode(), 0o10000000), 0o777) == 0",
    "a link of it": "assert c.link({file!r}.encode(), ({file!r} + '2').encode()) == 0",
    "a new file": "assert c.creat(({file!r} + '3').encode(), 0o666) >= 0",
    "a nameless file": "assert c.open(os.path.dirname({file!r}).encode(), 0o20200002, 0o666) >= 0",
    "its clock": "t = (ctypes.c_long * 2)(); assert c.clock_gettime(~{pid} << 3 | 2, t) == 0",
    "its limits by Python": "import resource; resource.prlimit({pid}, 7, (5, 5))",
    "its limits": "assert c.prlimit({pid}, 7, (ctypes.c_uint64 * 2)(1, 1), None) == 0",
    "its priority": "os.setpriority(0, {pid}, 19)",
    "a process": "assert c.fork() >= 0",
    "a process by clone": "assert c.syscall({clone}, 17, 0, 0, 0, 0) >= 0",
    "a process that shares": "assert c.vfork() >= 0",
    "another program": "os.execv('/bin/true', ['true'])",
    "to outlive the grader": "assert c.prctl(1, 0, 0, 0, 0) == 0",
    "to be root": "assert c.setuid(0) == 0 or c.setresuid(0, 0, 0) == 0",
    "more memory": "import resource; resource.setrlimit(resource.RLIMIT_AS, (-1, -1))",
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_other_ways_lead_nowhere(victim: Victim, way: str) -> None:
    before = victim.state
    clone = MACHINES[os.uname().machine].calls["clone"]
    code = WAYS[way].format(pid=victim.process.pid, file=str(victim.file), clone=clone)
    tried = "\n".join(f"    {line}" for line in code.splitlines())
    # What is refused by an exception is refused as well as what is by an error's number.
    body = f"try:\n{tried}\nexcept BaseException: return 1.0\nreturn 2.0"
    answer = 0.0
    try:
        answer = asked(body)
    except RuntimeError as error:
        assert "no lesson needs that" in str(error)
    assert answer != 2.0 or way.startswith("a signal to")
    assert victim.state == before
    assert victim.process.poll() is None


def test_it_can_still_end_itself_and_start_threads() -> None:
    body = """import threading, signal
said = []
threads = [threading.Thread(target=said.append, args=(n,)) for n in range(3)]
[t.start() for t in threads]; [t.join() for t in threads]
signal.signal(signal.SIGUSR1, lambda *_: said.append(9))
c.kill(os.getpid(), 10)
return float(sum(said))"""
    assert asked(body) == 12.0


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root can")
def test_root_starts_it_as_a_user_of_its_own_without_rights() -> None:
    body = """with open('/proc/cpuinfo') as f: f.read(1)
import scipy.linalg  # files of root's folders are read, where Python lies there
return float(os.getuid()) if os.getuid() == os.geteuid() else 0.0"""
    first, second = asked(body), asked(body)
    assert first > 60_000
    assert second > 60_000
    assert first != second or first == 65534
    assert asked("h = (ctypes.c_uint32 * 2)(0x20080522, 0)\nreturn float(c.setgid(0))") == -1.0


THREADED = """
import numpy as np
def f(a):
    import ctypes, os
    place = os.path.join(os.path.dirname(os.path.dirname(np.__file__)), 'numpy.libs')
    name = next(name for name in os.listdir(place) if 'openblas' in name)
    library = ctypes.CDLL(os.path.join(place, name))
    library.scipy_openblas_set_num_threads64_(3)
    m = np.random.default_rng(0).normal(size=(600, 600))
    wrong = np.abs(m @ np.linalg.inv(m) - np.eye(600)).max()
    return float(library.scipy_openblas_get_num_threads64_()) + float(wrong > 1e-6)
"""


def test_openblas_may_use_threads() -> None:
    with StudentProcess("mine.py", THREADED) as process:
        assert process.call("f", (ARRAY,)).result == 3.0


COMPILED = """
import numba
@numba.njit(parallel=True)
def total(x):
    s = 0.0
    for i in numba.prange(len(x)):
        s += x[i]
    return s
def f(a):
    import scipy.optimize, scipy.stats
    return total(a) + float(scipy.optimize.brentq(lambda x: x - 1, 0, 3))
"""


@pytest.mark.slow
def test_numba_and_scipy_work() -> None:
    with StudentProcess("mine.py", COMPILED) as process:
        assert process.call("f", (ARRAY,)).result == pytest.approx(4.0)


@pytest.mark.slow
@pytest.mark.parametrize("source", [ARRAYS, LOOPS], ids=["arrays", "loops"])
def test_the_solutions_of_all_lessons_pass(source: str) -> None:
    results = [grade(source, "mine.py", lesson) for lesson in lessons() if lesson.number <= 8]
    assert all(result.passed for result in results)
