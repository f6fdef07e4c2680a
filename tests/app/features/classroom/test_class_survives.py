"""What a student's code does, or who is killed, costs the others nothing: at a real JupyterHub."""

from __future__ import annotations

import json
import os
import signal
import time
from contextlib import suppress
from pathlib import Path

import pytest
from classes import RunningClass, needs_hub, running_class

from app.features.classroom.warm.watch import processes
from benchmarks.classroom import StudentClient

pytestmark = [pytest.mark.slow, needs_hub]
BACK_S = {"proxy": 10.0, "student": 10.0, "hub": 3.0}
"""Who drives notices nothing of a hub that was killed: its proxy outlives it."""
LINKS_S = 20.0
"""The goal is 10 s on a computer that does nothing else."""
PATIENCE_S = 40.0
SEEN_S = 20.0
ATTACKS = {
    "an endless loop": "while True:\n    pass\n",
    "ten gigabytes": "kept = bytearray(10 << 30)\n",
    "many processes": (
        "import os, time\n"
        "for _ in range(45):\n"  # the system refuses more than 120, and the watch 100
        "    if not os.fork():\n"
        "        import threading\n"
        "        for _ in range(2):\n"
        "            threading.Thread(target=time.sleep, args=(60,), daemon=True).start()\n"
        "        time.sleep(60)\n"
        "        os._exit(0)\n"
    ),
    "memory of several processes": (
        "import os, time\n"
        "for _ in range(4):\n"
        "    if not os.fork():\n"
        "        kept = bytearray(150 << 20)\n"  # one of them alone may have that
        "        kept[::4096] = b'x' * len(kept[::4096])\n"
        "        time.sleep(60)\n"
        "        os._exit(0)\n"
        "time.sleep(60)\n"
    ),
    "the others' files": (
        "import pathlib\n"
        "other = pathlib.Path.cwd().parent / 'bo' / 'my_filter.py'\n"
        "pathlib.Path('told').write_text(other.read_text())\n"
    ),
    "a full disk": (
        "import os, time\n"
        "for number in range(40):\n"
        "    open(f'much{number}', 'wb').write(b'x' * (1 << 20))\n"
        "time.sleep(60)\n"
    ),
}

ENDED = {
    "many processes": "processes and threads; valid are 100",
    "memory of several processes": "MB of memory; valid is 400",
    "a full disk": "MB; valid is 30: until you or your teacher remove something",
}
"""What a student is told whose programs were ended; with other bad code the robot stands still."""


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    folder = tmp_path_factory.mktemp("class")
    for above in (folder, *folder.parents):
        if above.name.startswith(("pytest-", "popen-")) or above == folder:
            above.chmod(0o711)
    words = ("--memory", "400", "--disk", "30")
    with running_class(folder, "Ada\nBo\n", *words) as running:
        yield running


@pytest.fixture(scope="module")
def students(served):
    made = {name: StudentClient(served.address, name, served.keys[name]) for name in ("ada", "bo")}
    for each in made.values():
        each.open()
        each.move(30.0)
    return made


def back(student: StudentClient) -> None:
    """Wait until a student drives again; a new server knows nobody, and the link signs in."""
    end = time.monotonic() + PATIENCE_S
    while not _drives(student):
        assert time.monotonic() < end, "the student's robot does not come back"
        time.sleep(0.1)


def longest_gap(student: StudentClient, seconds: float) -> float:
    """For how long a student could not drive, at the longest, within so much time [s]."""
    begun = last = time.monotonic()
    longest = 0.0
    while last - begun < seconds:
        if _drives(student):
            longest, last = max(longest, time.monotonic() - last), time.monotonic()
        assert time.monotonic() - last < PATIENCE_S, "the student's robot does not come back"
        time.sleep(0.1)
    return longest


def _drives(student: StudentClient) -> bool:
    with suppress(Exception):  # whatever a proxy without a server says
        student.move(3.0)
        return True
    with suppress(Exception):
        student.open()
    return False


def server_of(home: Path) -> int:
    """The server that works in a student's folder: its parent works elsewhere."""
    here = set()
    for pid in processes():
        with suppress(OSError):
            if Path(f"/proc/{pid}/cwd").readlink() == home.resolve():
                here.add(pid)
    return next(pid for pid in here if processes()[pid].parent not in here)


@pytest.mark.parametrize("attack", ATTACKS)
def test_a_students_code_takes_its_own_share_alone(attack, served, students):
    homes = served.folder / "students"
    ada, bo = homes / "ada", homes / "bo"
    (ada / "kept.txt").write_text("saved")
    ada_server, bo_server = server_of(ada), server_of(bo)
    (ada / "begun").unlink(missing_ok=True)
    begins = "open('begun', 'w').close()\n"
    file = ada / "my_filter.py"
    usual = file.read_text()
    file.write_text(f"{usual}\n{begins}{ATTACKS[attack]}")
    end = time.monotonic() + PATIENCE_S
    while not (ada / "begun").exists() and time.monotonic() < end:
        with suppress(Exception), students["ada"].socket("api/live?rate=5") as live:
            values = {"laser_model_type": "my_filter.py:MySensor"}
            live.send(json.dumps({"type": "set_parameters", "values": values, "id": 1}))
            for _ in range(10):
                live.recv(timeout=1.0)
    assert (ada / "begun").exists()
    students["bo"].move(20.0)
    assert server_of(bo) == bo_server
    while attack in ENDED and Path(f"/proc/{ada_server}").exists():
        assert time.monotonic() < end + PATIENCE_S, "nobody ends it"
        time.sleep(0.1)
    file.write_text(usual)
    for much in ada.glob("much*"):
        much.unlink()
    if attack not in ENDED:
        os.kill(ada_server, signal.SIGKILL)
    back(students["ada"])
    assert ENDED.get(attack, "") in students["ada"].ask("classroom")["ended"]
    assert (ada / "kept.txt").read_text() == "saved"
    assert not (ada / "told").exists()


@pytest.mark.real_time
@pytest.mark.parametrize("victim", ["proxy", "hub", "student"])
def test_who_is_killed_is_back_with_all_that_was_saved(victim, served, students):
    ada = served.folder / "students" / "ada"
    (ada / "kept.txt").write_text("saved")
    servers = {name: server_of(served.folder / "students" / name) for name in ("ada", "bo")}
    if victim == "student":
        pid = servers.pop("ada")
    else:
        pid = _proxy(served) if victim == "proxy" else _hub(served)
    os.kill(pid, signal.SIGKILL)
    seconds = longest_gap(students["ada"], SEEN_S)
    print(f"{victim}: {seconds:.2f} s without a robot")
    assert seconds < BACK_S[victim]
    StudentClient(served.address, "bo", served.keys["bo"]).open()  # links open again, too
    students["bo"].move(20.0)
    for name, each in servers.items():
        assert server_of(served.folder / "students" / name) == each
    assert (ada / "kept.txt").read_text() == "saved"


@pytest.mark.real_time
def test_a_hub_that_was_killed_goes_on_with_the_proxy_of_before(served, students):
    before = _proxy(served)
    os.kill(_hub(served), signal.SIGKILL)
    with students["ada"].socket("api/live?rate=5") as live:
        begun = time.monotonic()
        # A browser that nobody has signed in yet: the hub alone can let it in.
        StudentClient(served.address, "bo", served.keys["bo"]).open()
        seconds = time.monotonic() - begun
        print(f"links open again after {seconds:.2f} s")
        assert seconds < LINKS_S
        live.recv(timeout=5.0)  # the one socket has lasted
    assert _proxy(served) == before


def _proxy(served: RunningClass) -> int:
    return int((served.folder / "proxy.pid").read_text())


def _hub(served: RunningClass) -> int:
    """The hub, a copy of the process that has imported it; it may just begin."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        own = [each for each in _below(served.process.pid) if _is_hub(each)]
        if len(own) == 2:
            return own[1]
        time.sleep(0.05)
    raise LookupError("there is no hub")


def _is_hub(pid: int) -> bool:
    with suppress(OSError):
        return b"classroom.hub.start\0" in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False


def _below(pid: int) -> list[int]:
    """All processes that descend from one, parents first."""
    found = [pid]
    for each in found:
        with suppress(OSError):
            for task in Path(f"/proc/{each}/task").iterdir():
                found += map(int, (task / "children").read_text().split())
    return found[1:]
