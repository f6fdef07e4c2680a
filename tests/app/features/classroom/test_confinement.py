"""A student's server sees its own folder alone, whatever the student's code tries."""

from __future__ import annotations

import ctypes
import errno
import json
import os
import platform
import socket
import sys
import traceback
from pathlib import Path

import pytest

from app.features.classroom.warm.confinement import MOST_FILE, MOST_PROCESSES, confine
from app.features.classroom.warm.request import Confinement

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Landlock is Linux's")


@pytest.fixture(params=["of root", "of somebody"])
def tried(request, tmp_path_factory):
    """Runs code as a student's server would, and returns what it says."""
    if request.param == "of root" and os.geteuid() != 0:
        pytest.skip("this user is not root")
    folder = tmp_path_factory.mktemp("class")
    for above in folder.parents:  # pytest's own folders are of the user alone
        if above.owner() == folder.owner() and above.name.startswith(("pytest-", "popen-")):
            above.chmod(0o711)
    folder.chmod(0o711)
    for name in ("ada", "bo"):
        home = folder / "students" / name
        home.mkdir(parents=True)
        (home / "my_filter.py").write_text(f"# of {name}")
    (folder / "keys.json").write_text('{"teacher": "secret"}')

    def run(code):
        return _in_a_fork(folder, code, as_root=request.param == "of root")

    return folder, run


def _in_a_fork(folder: Path, code, *, as_root: bool):
    read, write = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            home = folder / "students" / "ada"
            if not as_root and os.geteuid() == 0:
                for path in (folder, *folder.rglob("*")):
                    os.chown(path, 1_700_000_000, 1_700_000_000)
                os.setresgid(*(1_700_000_000,) * 3)
                os.setresuid(*(1_700_000_000,) * 3)
            fences = confine(
                Confinement(str(folder), str(home), 7, 400 * 1024 * 1024, 5_001, 5_002)
            )
            os.chdir(home)
            told = {"fences": fences, "told": code(folder, home)}
        except BaseException:
            told = {"failure": traceback.format_exc()}
        os.write(write, json.dumps(told).encode())
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as answers:
        told = json.loads(answers.read())
    os.waitpid(pid, 0)
    assert "failure" not in told, told["failure"]
    if "Landlock" not in told["fences"] and not as_root:
        pytest.skip("this kernel has no Landlock")
    return told["told"]


def error_of(action) -> str:
    try:
        action()
    except OSError as error:
        return type(error).__name__
    except MemoryError:
        return "MemoryError"
    return "done"


def test_no_file_of_others_is_read_written_or_listed(tried, request):
    of_root = "of root" in request.node.name

    def code(folder, home):
        other = folder / "students" / "bo" / "my_filter.py"
        return {
            "own": error_of(lambda: (home / "my_filter.py").write_text("mine")),
            "new": error_of((home / "kept").mkdir),
            "other": error_of(other.read_text),
            "written": error_of(lambda: other.write_text("changed")),
            "link": error_of(lambda: os.link(other, home / "link")),
            "mode": error_of(lambda: other.chmod(0o777)),
            "times": error_of(lambda: os.utime(other, (1, 1))),
            "folder": error_of(lambda: list(other.parent.iterdir())),
            "keys": error_of((folder / "keys.json").read_text),
            "system": error_of(Path("/etc/shadow").read_text),
            "program": error_of(lambda: (Path(__file__).parent / "x").write_text("")),
        }

    folder, run = tried
    told = run(code)
    assert (told.pop("own"), told.pop("new")) == ("done", "done")
    if not of_root:  # students share a user then, and Landlock knows neither modes nor times
        del told["mode"], told["times"]
    assert set(told.values()) <= {"PermissionError", "OSError"}, told
    assert (folder / "students" / "bo" / "my_filter.py").read_text() == "# of bo"


def test_memory_and_files_end(tried):
    def code(folder, home):
        import resource

        with (home / "long").open("wb") as file:
            long = error_of(lambda: file.truncate(MOST_FILE + 1))
        return {
            "memory": error_of(lambda: bytearray(600 * 1024 * 1024)),
            "long": long,
            "processes": resource.getrlimit(resource.RLIMIT_NPROC)[0],
            "core": resource.getrlimit(resource.RLIMIT_CORE)[0],
        }

    import signal

    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    _, run = tried
    told = run(code)
    signal.signal(signal.SIGXFSZ, before)
    assert (told["memory"], told["long"], told["core"]) == ("MemoryError", "OSError", 0)
    assert told["processes"] in (MOST_PROCESSES, told["processes"])


def test_no_port_of_others_is_reached(tried):
    def code(folder, home):
        import socket

        def connect():
            with socket.socket() as one:
                one.connect(("127.0.0.1", port))

        def listen(own: int):
            with socket.socket() as one:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                one.bind(("127.0.0.1", own))

        return {
            "version": ctypes.CDLL(None).syscall(444, None, 0, 1), "connect": error_of(connect),
            "listen": error_of(lambda: listen(0)), "own": error_of(lambda: listen(5_001)),
        }  # fmt: skip

    _, run = tried
    with socket.socket() as others:
        others.bind(("127.0.0.1", 0))
        others.listen()
        port = others.getsockname()[1]
        told = run(code)
    if told["version"] < 4:
        pytest.skip("this kernel's Landlock knows no ports")
    assert (told["connect"], told["listen"], told["own"]) == ("PermissionError",) * 2 + ("done",)


def test_processes_of_others_are_out_of_reach_as_root(tried, request):
    if "of root" not in request.node.name:
        pytest.skip(
            "without root, students share a user: Landlock refuses signals from version 6 on"
        )
    parent = os.getpid()

    def code(folder, home):
        import resource

        return {
            "signal": error_of(lambda: os.kill(parent, 0)),
            "priority": error_of(lambda: os.setpriority(os.PRIO_PROCESS, parent, 5)),
            "environment": error_of(lambda: Path(f"/proc/{parent}/environ").read_bytes()),
            "processes": resource.getrlimit(resource.RLIMIT_NPROC)[0],
        }

    _, run = tried
    told = run(code)
    assert told.pop("processes") == MOST_PROCESSES
    assert set(told.values()) == {"PermissionError"}


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the numbers are those of x86-64")
def test_calls_by_number_that_once_left_the_graders_sandbox_lead_nowhere_as_root(tried, request):
    if "of root" not in request.node.name:
        pytest.skip("without root, students share a user: docs/classroom.md says so")
    parent = os.getpid()

    def code(folder, home):
        libc = ctypes.CDLL(None, use_errno=True)
        other = os.fsencode(folder / "students" / "bo" / "my_filter.py")
        info = (ctypes.c_int * 32)(0, 0, -1)
        calls = {
            "rt_sigqueueinfo": (129, parent, 0, info),
            "fchmodat2": (452, -100, other, 0o777, 0),
            "utimes": (235, other, None),
            "setpriority": (141, 0, parent, 10),
        }
        return {name: (libc.syscall(*call), ctypes.get_errno()) for name, call in calls.items()}

    folder, run = tried
    other = folder / "students" / "bo" / "my_filter.py"
    before = other.stat()
    told = run(code)
    unknown = [errno.ENOSYS] * (told["fchmodat2"][1] == errno.ENOSYS)  # an older kernel's
    allowed = {errno.EPERM, errno.EACCES, *unknown}
    assert all(result == -1 and number in allowed for result, number in told.values()), told
    after = other.stat()
    assert (after.st_mode, after.st_mtime) == (before.st_mode, before.st_mtime)
