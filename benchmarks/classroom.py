"""What a class costs one machine: a link until the robot moves, memory and work of each student.

``python -m benchmarks.classroom [--students 12] [--port 8950]`` needs the packages of
``brickpose[class]``. Students are simulated by their sockets: each opens the link, signs in at the
hub, drives, and takes telemetry and pictures as a page does.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import HTTPCookieProcessor, ProxyHandler, build_opener

from websockets.sync.client import ClientConnection, connect

from benchmarks.programs import started

MOVED_M = 0.005
PATIENCE_S = 120.0
AGAIN_S = 10.0
REFUSED_S = 0.2
AWAKE_S = 20.0
QUIET_S = 20.0


class StudentClient:
    """A student's browser, as far as servers notice it."""

    def __init__(self, address: str, login: str, key: str, path: str = "") -> None:
        """Prepare to open a link; the page is the student's own, or that of another ``path``."""
        self.login = login
        self._address = address
        self._jar = CookieJar()
        self._opener = build_opener(ProxyHandler({}), HTTPCookieProcessor(self._jar))
        self._opener.addheaders = [("Accept", "text/html")]
        self._link = f"{address}/hub/enter/{key}"
        self._path = path or f"/user/{login}/"
        self._page = f"{address}{self._path}"

    def open(self) -> None:
        """Open the link, and wait for the student's own page."""
        end, next_try = time.monotonic() + PATIENCE_S, 0.0
        while time.monotonic() < end:
            if time.monotonic() >= next_try:
                next_try = time.monotonic() + AGAIN_S
                try:
                    with self._opener.open(self._link, timeout=PATIENCE_S) as answer:
                        if answer.url.startswith(self._page):
                            return
                except HTTPError:
                    # While a hub is begun again, its proxy says that it does not answer.
                    next_try = time.monotonic() + REFUSED_S
            with (
                suppress(HTTPError),
                self._opener.open(self._page, timeout=PATIENCE_S) as answer,
            ):
                if "/hub/" not in answer.url:
                    return
            time.sleep(0.02)
        raise TimeoutError(f"{self.login}'s page does not come")

    def socket(self, path: str) -> ClientConnection:
        """Open a socket of the page."""
        cookies = "; ".join(
            f"{each.name}={each.value}" for each in self._jar if self._path.startswith(each.path)
        )
        place = self._page.replace("http", "ws", 1) + path
        headers = {"Cookie": cookies}
        return connect(place, additional_headers=headers, max_size=None, proxy=None)

    def move(self, patience: float = PATIENCE_S) -> None:
        """Drive until the robot has moved; raise a TimeoutError if it does not [s]."""
        with self.socket("api/live?rate=30") as live:
            first = None
            end = time.monotonic() + patience
            while True:
                message = json.loads(live.recv(timeout=max(end - time.monotonic(), 0.01)))
                if message["type"] != "telemetry" or message["truth"] is None:
                    continue
                first = first or message["truth"]
                place = message["truth"]
                if math.dist((place["x"], place["y"]), (first["x"], first["y"])) > MOVED_M:
                    return
                live.send(json.dumps({"type": "drive", "v": 0.15, "omega": 0.3}))

    def ask(self, path: str, body: dict[str, str] | None = None) -> Any:
        """Return the JSON of an address below the page."""
        data = None if body is None else json.dumps(body).encode()
        with self._opener.open(f"{self._page}{path}", data, timeout=PATIENCE_S) as answer:
            return json.load(answer)

    def is_asleep(self) -> bool:
        """Whether the robot sleeps; to ask does not wake it."""
        return bool(self.ask("classroom")["asleep"])

    def stay(
        self,
        ended: threading.Event,
        delays: list[float],
        stamps: list[float],
        pictures: list[float],
    ) -> None:
        """Drive in circles and take pictures until it ends; note the delay of clicks [s]."""
        with self.socket("api/live?rate=30") as live, self.socket("api/camera") as camera:
            drain = threading.Thread(target=_drain, args=(camera, ended, pictures), daemon=True)
            drain.start()
            sent, number = time.monotonic(), 0
            while not ended.is_set():
                message: dict[str, Any] = json.loads(live.recv(timeout=PATIENCE_S))
                if message["type"] in ("ack", "error"):
                    if message["id"] == number:
                        delays.append(time.monotonic() - sent)
                    continue
                number, sent = number + 1, time.monotonic()
                drive = {"type": "drive", "v": 0.1, "omega": 0.8, "id": number}
                live.send(json.dumps(drive))
                stamps.append(float(message["stamp"]))
            drain.join(PATIENCE_S)


def _drain(camera: ClientConnection, ended: threading.Event, pictures: list[float]) -> None:
    while not ended.is_set():
        with suppress(TimeoutError):
            camera.recv(timeout=1.0)
            pictures.append(time.monotonic())


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.classroom", description=__doc__)
    parser.add_argument("--students", type=int, default=12)
    parser.add_argument("--port", type=int, default=8950)
    parser.add_argument("--soak", type=float, metavar="MINUTES", help="students come and go")
    options = parser.parse_args()
    if options.soak:
        return _soak(options.students, options.port, options.soak * 60)
    with _class(options.students, options.port) as (running, address, folder):
        keys = json.loads((folder / "keys.json").read_text())
        logins = [login for login in keys if login != "teacher"]
        students = [StudentClient(address, login, keys[login]) for login in logins]
        before = _processes(folder)
        opened = []
        for student in students:
            begun = time.monotonic()
            student.open()
            student.move()
            opened.append(time.monotonic() - begun)
        _say("link opened until the robot moves, p95", _p95(opened), "s")
        _say("  the same, median", statistics.median(opened), "s")
        own = [pid for pid in _processes(folder) if pid not in before]
        private = sum(_memory(pid, "Private_Dirty") for pid in own) / len(students)
        _say("private memory of a student", private, "MB")
        everything = sum(_memory(pid, "Pss") for pid in {*before, *own})
        _say(f"warm parent and {len(students)} students together", everything, "MB")
        _awake(students, own)
        _asleep(students, own, _descendants(running.pid))
    return 0


def _soak(count: int, port: int, seconds: float) -> int:
    """Let students come, drive and leave; print the memory of what lasts, and what is left."""
    with _class(count, port, "--idle", "1") as (running, _, folder):
        keys = json.loads((folder / "keys.json").read_text())
        address = f"http://127.0.0.1:{port}"
        students = [StudentClient(address, n, keys[n]) for n in keys if n != "teacher"]
        parent, ended, visits = _processes(folder), threading.Event(), [0] * count
        started_at = time.monotonic()
        with ThreadPoolExecutor(count) as pool:
            going = [
                pool.submit(_come_and_go, student, number, ended, visits)
                for number, student in enumerate(students)
            ]
            while time.monotonic() - started_at < seconds:
                time.sleep(min(30.0, seconds / 5))
                warm = _processes(folder)
                hub = [pid for pid in _descendants(running.pid) if pid not in warm]
                words = ", ".join(f"{_name(pid)} {_memory(pid, 'Pss'):.0f}" for pid in hub)
                servers = len(warm) - len(parent)
                _say(f"{words} MB; {servers} processes of students; warm parent",
                     _memory(parent[0], "Rss"), "MB")  # fmt: skip
            ended.set()
            for each in going:
                each.result()
        _say("visits", sum(visits), "")
    time.sleep(1.0)
    left = _processes(folder) + [
        p for p in _descendants(running.pid) if Path(f"/proc/{p}").exists()
    ]
    _say("processes left over", len(left), "")
    return 1 if left else 0


def _come_and_go(
    student: StudentClient, number: int, ended: threading.Event, visits: list[int]
) -> None:
    chance = random.Random(number)
    while not ended.wait(chance.uniform(0.0, 20.0)):
        student.open()
        student.move()
        visits[number] += 1
        gone = threading.Timer(chance.uniform(3.0, 30.0), lambda: None)
        gone.start()
        with student.socket("api/live?rate=10") as live:
            while gone.is_alive() and not ended.is_set():
                live.recv(timeout=PATIENCE_S)
        if chance.random() < 0.4 and ended.wait(chance.uniform(100.0, 150.0)):
            return  # so long that the robot was ended meanwhile


def _name(pid: int) -> str:
    words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    known = (b"jupyterhub_idle_culler", b"wall.service", b"configurable", b"jupyterhub", b"class")
    return next((k.decode() for k in known if any(k in word for word in words)), "other")


def _awake(students: list[StudentClient], own: list[int]) -> None:
    ended = threading.Event()
    delays: list[float] = []
    pictures: list[float] = []
    stamps: dict[str, list[float]] = {student.login: [] for student in students}
    drives = [pid for pid in own if _parent(pid) in own]
    serves = [pid for pid in own if pid not in drives]
    with ThreadPoolExecutor(len(students)) as pool:
        running = [
            pool.submit(student.stay, ended, delays, stamps[student.login], pictures)
            for student in students
        ]
        time.sleep(2.0)
        begun, work, seen = time.monotonic(), _work(own), len(pictures)
        waits = [_waits(pids) for pids in (drives, serves)]
        time.sleep(AWAKE_S)
        waited = [_waited(b, pids) for b, pids in zip(waits, (drives, serves), strict=True)]
        rate = (len(pictures) - seen) / (time.monotonic() - begun) / len(students)
        share = _seconds_since(work, own) / (time.monotonic() - begun) / len(students)
        ended.set()
        for each in running:
            each.result()
    _say(f"driving, {len(students)} at once: processor of each", share * 100, "% of a core")
    _say("  pictures of each", rate, "a second")
    for part, wait in zip(("what drives", "what serves"), waited, strict=True):
        _say(f"  {part} waits for the processor, each time", wait * 1000, "ms")
    _say("  command until its answer, p95", _p95(delays) * 1000, "ms")
    gaps = [b - a for each in stamps.values() for a, b in itertools.pairwise(each)]
    _say("  between two messages of telemetry, p99", _p95(gaps, 0.99) * 1000, "ms")


def _asleep(students: list[StudentClient], own: list[int], hub: list[int]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not all(student.is_asleep() for student in students):
        if time.monotonic() > end:
            raise TimeoutError("a robot that nobody looks at does not sleep")
        time.sleep(1.0)
    time.sleep(2.0)  # what ends with the last look
    begun, work, around = time.monotonic(), _work(own), _work(hub)
    time.sleep(QUIET_S)
    seconds = time.monotonic() - begun
    share = _seconds_since(work, own) / seconds / len(students)
    _say("nobody looks: processor of each", share * 100, "% of a core")
    _say(
        "  hub, proxy and wall together", _seconds_since(around, hub) / seconds * 100, "% of a core"
    )


@contextmanager
def _class(
    count: int, port: int, *options: str
) -> Iterator[tuple[subprocess.Popen[str], str, Path]]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder.chmod(0o711)
        names = folder / "students.csv"
        names.write_text("\n".join(f"student {n}" for n in range(count)), encoding="utf-8")
        words = ("class", str(names), "--host", "127.0.0.1", "--port", str(port), *options)
        begun = time.monotonic()
        running, address = stack.enter_context(started(*words, says=r"students at (http://\S+)"))
        _say(f"command until {count} links hold", time.monotonic() - begun, "s")
        yield running, address, names.with_suffix(".class")


def _processes(folder: Path) -> list[int]:
    """Return the warm parent and its copies: their command line names the class's folder."""
    wanted = os.fsencode(folder / "warm.sock")
    pids = []
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if wanted in (place / "cmdline").read_bytes():
                pids.append(int(place.name))
    return pids


def _descendants(pid: int) -> list[int]:
    """Return the hub, its proxy and its services: what the class's command has begun."""
    pids = [pid]
    for each in pids:
        with suppress(OSError):
            for task in Path(f"/proc/{each}/task").iterdir():
                pids += map(int, (task / "children").read_text().split())
    return pids[1:]


def _memory(pid: int, kind: str) -> float:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return sum(float(line.split()[1]) for line in lines if line.startswith(f"{kind}:")) / 1024


def _work(pids: list[int]) -> dict[Path, int]:
    """Return the processor time of each thread [ns]: sleepers work in crumbs."""
    work = {}
    for pid in pids:
        with suppress(OSError):
            for task in Path(f"/proc/{pid}/task").iterdir():
                with suppress(OSError):
                    work[task] = int((task / "schedstat").read_text().split()[0])
    return work


def _parent(pid: int) -> int:
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


def _waits(pids: list[int]) -> dict[int, tuple[int, int]]:
    """Return of each main thread how long it has waited for a processor [ns], and how often."""
    waits = {}
    for pid in pids:
        _, waited, count = Path(f"/proc/{pid}/schedstat").read_text().split()
        waits[pid] = int(waited), int(count)
    return waits


def _waited(before: dict[int, tuple[int, int]], pids: list[int]) -> float:
    """Return how long they waited since then each time, on average [s]."""
    waits = _waits(pids)
    seconds = sum(waits[pid][0] - before[pid][0] for pid in pids) / 1e9
    return seconds / max(sum(waits[pid][1] - before[pid][1] for pid in pids), 1)


def _seconds_since(before: dict[Path, int], pids: list[int]) -> float:
    """Return the processor time since then [s]; threads that have ended meanwhile do not count."""
    return sum(work - before.get(task, 0) for task, work in _work(pids).items()) / 1e9


def _p95(values: list[float], share: float = 0.95) -> float:
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else 0.0


def _say(figure: str, value: float, unit: str) -> None:
    sys.stdout.write(f"{figure}: {value:.3g} {unit}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    raise SystemExit(main())
