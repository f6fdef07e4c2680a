"""The program on a computer without Unix, as far as Linux can be one: a test runs it as a program.

It takes away what Windows does not have, imports the program, and forks once for each line
``{"arguments", "folder", "name", "serves"}`` on standard input. The child runs the command, with
its output in ``NAME.out`` and ``NAME.err``, and writes its exit code to ``NAME.code``. The answer
is a line with its number, after its end unless it serves.

Simulated is what a module of ours can see: modules that are missing, attributes of ``os``,
``signal``, ``socket``, ``time`` and ``select`` that are missing, ``sys.platform``, arguments of
``Popen`` that Windows refuses, ``select`` that takes sockets only, ``kernel32`` (with a job that
knows its process), an encoding with few signs. The standard library and other people's packages
are loaded before and keep all they have. Not simulated: Windows' paths, ``os.name`` (pathlib would
break), files that cannot be replaced while they are open, and the packages' own work there.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import os
import select
import socket
import stat
import subprocess
import sys
import sysconfig
import traceback
import types
from pathlib import Path

from places import ROOT

MODULES = (
    "fcntl", "resource", "termios", "pty", "tty", "pwd", "grp", "crypt", "syslog", "readline",
)  # fmt: skip
ATTRIBUTES = {
    "os": (
        "fork", "forkpty", "killpg", "getpgid", "setpgid", "setsid", "getuid", "geteuid", "getgid",
        "getegid", "setuid", "setpriority", "getpriority", "nice", "sched_getaffinity",
        "sched_setaffinity", "sysconf", "getloadavg", "openpty", "ttyname", "mkfifo", "mknod",
        "fchmod", "fchown", "chown", "statvfs", "fstatvfs", "pread", "pwrite", "fdatasync", "sync",
        "posix_fadvise", "posix_spawn", "pidfd_open", "wait", "waitid", "WNOHANG", "uname", "major",
        "minor", "memfd_create", "eventfd", "register_at_fork", "PRIO_PROCESS", "O_CLOEXEC",
        "O_NONBLOCK", "O_PATH", "O_NOFOLLOW", "O_DIRECTORY",
    ),
    "signal": (
        "SIGHUP", "SIGALRM", "SIGKILL", "SIGSTOP", "SIGCONT", "SIGUSR1", "SIGUSR2", "SIGPIPE",
        "SIGCHLD", "SIGQUIT", "SIGTTIN", "SIGTTOU", "SIGWINCH", "SIGXCPU", "alarm", "setitimer",
        "getitimer", "pause", "pthread_sigmask", "pthread_kill", "sigwait", "sigpending",
        "siginterrupt", "ITIMER_REAL", "ITIMER_PROF", "SIG_BLOCK", "SIG_UNBLOCK", "SIG_SETMASK",
    ),
    "socket": (
        "AF_UNIX", "SO_REUSEPORT", "SOCK_NONBLOCK", "SOCK_CLOEXEC", "SO_BINDTODEVICE",
        "sethostname",
    ),
    "time": (
        "CLOCK_BOOTTIME", "CLOCK_MONOTONIC", "CLOCK_THREAD_CPUTIME_ID", "clock_gettime", "tzset",
        "pthread_getcpuclockid",
    ),
    "select": ("poll", "epoll"),
}  # fmt: skip
SIGBREAK = 21
"""Windows' number of it; Linux sends the same one as SIGTTIN."""
USED_FIRST = (
    "asyncio", "multiprocessing.popen_spawn_posix", "multiprocessing.resource_tracker",
    "multiprocessing.synchronize", "concurrent.futures.process", "ctypes", "numba", "cv2",
    "numba.np.ufunc.parallel", "numba.cpython.mathimpl", "numba.cpython.cmathimpl",
    "numba.np.npyimpl", "numba.np.linalg", "numba.np.arraymath",
    "numba.np.math.mathimpl", "numba.np.ufunc_db", "numba.core.externals",
    "scipy.optimize", "scipy.spatial.transform", "scipy.ndimage",
    "scipy.sparse.linalg", "scipy.interpolate", "scipy.stats", "shapely", "yaml",
    "anyio._backends._asyncio", "matplotlib.figure", "matplotlib.backends.backend_svg",
    "uvicorn.protocols.websockets.websockets_sansio_impl", "fastapi", "viser", "rosbags",
    "rosbags.typesys.stores", "mcap.writer", "lz4.frame", "zstandard", "jinja2",
    "cssselect2.parser",
    "serial.tools.list_ports", "tqdm", "babel.messages.pofile", "markdown_it",
    "websockets.sync.client",
)  # fmt: skip
"""The standard library's and other people's, which have parts of their own for Windows."""


class WindowsPopen(subprocess.Popen):
    """Refuses what Windows refuses, and takes its flags."""

    def __init__(self, *arguments, creationflags: int = 0, **options) -> None:
        unix = {"preexec_fn", "pass_fds", "start_new_session", "process_group", "umask", "user"}
        assert not unix & options.keys(), f"Windows has no {unix & options.keys()}"
        super().__init__(*arguments, **options)


class Kernel32:
    """What the program calls of Windows' own library; a process is a handle of its number."""

    def __init__(self) -> None:
        for name, answer in {
            "CreateJobObjectW": lambda *_: 77,
            "OpenProcess": lambda access, inherits, pid: pid,
            "AssignProcessToJobObject": self._assign,
            "SetInformationJobObject": lambda *_: 1,
            "QueryInformationJobObject": self._account,
            "CloseHandle": lambda handle: 1,
            "SetConsoleCtrlHandler": lambda handler, add: 1,
            "GetCurrentProcess": lambda: 1,
            "SetPriorityClass": lambda *_: 1,
        }.items():
            setattr(self, name, _Call(answer))
        self._pid = 0

    def _assign(self, job: int, pid: int) -> int:
        self._pid = pid
        return int(job == 77)

    def _account(self, job: int, kind: int, told, size: int, _) -> int:
        fields = Path(f"/proc/{self._pid}/stat").read_text().rpartition(")")[2].split()
        told._obj.TotalUserTime = (int(fields[11]) + int(fields[12])) * 100_000
        return 1


class _Call:
    """A function of a library, whose types can be set."""

    def __init__(self, function) -> None:
        self._function = function

    def __call__(self, *arguments):
        return self._function(*arguments)


def take_away() -> None:
    """Take Unix away from what is imported from now on.

    Modules lose attributes as copies: who has the whole module, keeps it.
    """
    sysconfig.get_config_vars()  # this Python's, which are known by its platform
    for name, attributes in ATTRIBUTES.items():
        whole = sys.modules[name]
        rest = types.ModuleType(name)
        rest.__dict__.update({k: v for k, v in vars(whole).items() if k not in attributes})
        sys.modules[name] = rest
    for name in MODULES:
        sys.modules[name] = None
    sys.modules["signal"].SIGBREAK = SIGBREAK
    sys.modules["socket"].SO_EXCLUSIVEADDRUSE = socket.SO_REUSEADDR  # what Linux means by it
    sys.modules["select"].select = lambda *arguments: select.select(
        *map(_only_sockets, arguments[:3]), *arguments[3:]
    )
    subprocess.Popen = WindowsPopen
    ctypes.WinDLL = lambda name, **_: Kernel32()
    ctypes.get_last_error = lambda: 5
    for name, module in sys.modules.items():
        if name.startswith(("multiprocessing.", "numba.")) and "sys" in vars(module):
            module.sys = _TrueSys()
    sys.platform = "win32"


class _TrueSys:
    """``sys`` for those who choose while they run how processes or code are made on Linux."""

    platform = "linux"

    def __getattr__(self, name: str):
        return getattr(sys, name)

    def __setattr__(self, name: str, value) -> None:
        setattr(sys, name, value)


def _only_sockets(asked):
    for item in asked:
        number = item if isinstance(item, int) else item.fileno()
        if not stat.S_ISSOCK(os.fstat(number).st_mode):
            raise OSError(10038, "An operation was attempted on something that is not a socket")
    return asked


def begin() -> None:
    """Load other people's packages, take Unix away, and prepare our own processes for the same."""
    for name in USED_FIRST:
        importlib.import_module(name)
    take_away()
    sys.path.insert(0, str(ROOT))
    from app.features.course.sandbox import student_process

    helpers = str(Path(__file__).parent)
    here = f"import sys; sys.path.insert(0, {helpers!r}); import without_unix; "
    student_process.START = f"{here}import numpy; without_unix.take_away(); {student_process.START}"


def main() -> None:
    """Carry out the orders on standard input; answer each with a line."""
    begin()
    for name in ("app.command_line", "app.engine.build", "app.page.serving"):
        importlib.import_module(name)
    for line in sys.stdin:
        order = json.loads(line)
        pid = os.fork()
        if pid == 0:
            _run(order["arguments"], Path(order["folder"]), order["name"])
        if not order["serves"]:
            os.waitpid(pid, 0)
        print(pid, flush=True)


def _run(arguments: list[str], folder: Path, name: str) -> None:
    """Run a command and end: the test's own threads and files stay in the other process."""
    code = 70
    os.chdir(folder)
    for number, ending in ((1, "out"), (2, "err")):
        file = os.open(f"{name}.{ending}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(file, number)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = open(1, "w", encoding="cp1252", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="cp1252", closefd=False)  # noqa: SIM115
    sys.argv = ["brickpose", *arguments]
    try:
        from app.__main__ import main as brickpose

        code = brickpose()
    except SystemExit as left:
        code = left.code
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    unfinished = Path(f"{name}.unfinished")
    unfinished.write_text(str(code), encoding="ascii")
    unfinished.replace(f"{name}.code")
    os._exit(0)


if __name__ == "__main__":
    main()
elif __name__ == "__mp_main__":
    begin()  # a process that the program has started
