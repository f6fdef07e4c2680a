"""``brickpose class``: checks everything, writes the hub's files, and keeps the hub running."""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import ProxyHandler, build_opener

from app.console import say
from app.engine.compiling.terminal import compile_first
from app.features.classroom.class_folder import ClassFolder
from app.features.classroom.hub_client import OTHER_PROXY
from app.features.classroom.links_page import link_of, write_links
from app.features.classroom.roster import TEACHER, Student, read_roster
from app.features.classroom.warm.ending import end_copies, end_others, end_proxy, end_services
from app.features.classroom.warm.request import WarmParentError, start_parent
from app.files import atomic_file
from app.page.address import own_address
from robot.errors import BrickPoseError
from robot.settings import SettingError

HUB = (5, 7)
"""The hub's versions that the tests run with: from the first, before the second."""
PACKAGES = {
    "jupyterhub": "jupyterhub",
    "jupyterhub-idle-culler": "jupyterhub_idle_culler",
    "configurable-http-proxy": "configurable_http_proxy",
}
NOTEBOOK_PACKAGES = {"jupyterlab": "jupyterlab", "jupyter-server-proxy": "jupyter_server_proxy"}
HUB_MODULE = "app.features.classroom.hub.start"
CURE = "python -m pip install 'brickpose[class]'"
NOTEBOOK_CURE = f"python -m pip install {' '.join(NOTEBOOK_PACKAGES)}"
WORSE_AFTER_S = 10.0
MOST_FAILURES = 3
END_S, HUB_END_S = 4.0, 5.0
"""Servers and hub are killed that have not ended after so long [s]."""
ANSWER_S, LOOK_S = 10.0, 0.2
CONFIG = """\
# Written anew at each start of `brickpose class`; docs/classroom.md has what each line means.
from app.features.classroom.hub.configuration import configure

configure(
    c,  # noqa: F821
    {folder!r},
    host={host!r},
    port={port},
    memory_mb={memory},
    disk_mb={disk},
    idle_s={idle},
    notebook={notebook},
    shared_robot={shared!r},
    turn_min={turn},
)
"""


class ClassError(BrickPoseError, RuntimeError):
    """The class cannot be served; the message says what is missing."""


def serve_class(parsed: argparse.Namespace) -> int:
    """Serve a class until a signal; return 0.

    Raises:
        BrickPoseError: something is missing or wrong; nothing was started then.
    """
    students = read_roster(parsed.students)
    _check_options(parsed)
    _check_packages(notebook=parsed.notebook)
    folder = ClassFolder(
        (getattr(parsed, "folder", None) or parsed.students.with_suffix(".class")).absolute()
    )
    if not parsed.write_only:
        _check_ports(parsed.host, parsed.port, shared="shared_robot" in parsed)
    folder.make()
    address = (getattr(parsed, "address", None) or _address(parsed.host, parsed.port)).rstrip("/")
    keys = folder.keys(students)
    folder.write_names(students)
    _write(folder, parsed)
    write_links(folder.links, address, students, keys)
    say(f"{len(students)} students; the page with their links, to print: {folder.links}")
    if parsed.write_only:
        return 0
    compile_first()  # else each student would wait for that
    if not parsed.notebook:
        with suppress(WarmParentError):  # then each server starts by itself
            start_parent(folder.warm_socket)
    return _keep_running(folder, address, students, keys[TEACHER], parsed.port)


def _check_options(parsed: argparse.Namespace) -> None:
    limits = {
        "port": (1, 65531),
        "memory": (300, 1_000_000),
        "disk": (10, 1_000_000),
        "idle": (1, 100_000),
        "turn": (0.1, 60),
    }
    for name, (low, high) in limits.items():
        if not low <= getattr(parsed, name) <= high:
            raise SettingError(f"--{name} is {getattr(parsed, name)}; valid are {low} to {high}")
    address = getattr(parsed, "address", None)
    if address is not None and (
        urlsplit(address).scheme not in ("http", "https") or not urlsplit(address).hostname
    ):
        raise SettingError(f"--address is {address!r}; valid is http://NAME:PORT")
    if sys.platform == "win32":
        raise ClassError("JupyterHub does not run on Windows; valid are Linux and macOS, or WSL")
    if parsed.notebook and os.geteuid() == 0:
        raise ClassError(
            "--notebook as root would make each student root; valid is another user, or a class "
            "without --notebook, whose students have users of their own"
        )


def _check_packages(*, notebook: bool) -> None:
    """Raise a ClassError if something is not installed, or of another version than was tried."""
    for packages, cure in (PACKAGES, CURE), (NOTEBOOK_PACKAGES if notebook else {}, NOTEBOOK_CURE):
        for package, module in packages.items():
            if importlib.util.find_spec(module) is None:
                raise ClassError(f"the package {package} is missing: {cure}")
    version = importlib.metadata.version("jupyterhub")
    installed = int(re.match(r"\d*", version)[0] or 0)  # type: ignore[index] # matches anything
    if not HUB[0] <= installed < HUB[1]:
        raise ClassError(
            f"JupyterHub {version} is installed; valid is {HUB[0]} up to, but without, {HUB[1]}: "
            f"{CURE}"
        )
    other = os.environ.get(OTHER_PROXY, "").split()
    if other and shutil.which(other[0]) is None:
        raise ClassError(
            f"{OTHER_PROXY} is {other[0]!r}, and there is no such program; without {OTHER_PROXY} "
            "the proxy in Python is used, which needs no node"
        )
    if other and _needs_node(other[0]) and shutil.which("node") is None:
        raise ClassError(
            f"{OTHER_PROXY} is {other[0]!r}, which needs node, and node is not there; without "
            f"{OTHER_PROXY} the proxy in Python is used"
        )


def _needs_node(program: str) -> bool:
    """Whether a program is a script of node's, as all of npm's are."""
    with open(shutil.which(program) or program, "rb") as file:  # noqa: PTH123 - what PATH has
        return b"node" in file.readline(100)


def _check_ports(host: str, port: int, *, shared: bool) -> None:
    """Raise a ClassError if one of the ports is taken, or the address is not of this machine."""
    uses = ["the hub", "the proxy's interface", "the wall", *(["the shared robot"] * shared)]
    own = [("127.0.0.1", port + number, use) for number, use in enumerate(uses, 1)]
    for address, each, use in [(host, port, "the class"), *own]:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((address, each))
            except OSError as error:
                raise ClassError(
                    f"cannot listen on {address} port {each}, for {use}: {error.strerror}; four "
                    "free ports one after the other are chosen by --port"
                ) from error


def _address(host: str, port: int) -> str:
    shown = own_address() if host in ("0.0.0.0", "::") else host
    return f"http://{shown}:{port}"


def _write(folder: ClassFolder, parsed: argparse.Namespace) -> None:
    with atomic_file(folder.config) as unfinished:
        unfinished.write_text(
            CONFIG.format(
                folder=str(folder.path), host=parsed.host, port=parsed.port,
                memory=parsed.memory, disk=parsed.disk, idle=parsed.idle * 60,
                notebook=parsed.notebook, shared=getattr(parsed, "shared_robot", None),
                turn=parsed.turn,
            ),
            encoding="utf-8",
        )  # fmt: skip


def _keep_running(
    folder: ClassFolder, address: str, students: tuple[Student, ...], key: str, port: int
) -> int:
    """Run the hub, and start it again if it dies; end it by a signal.

    Raises:
        ClassError: it dies at once, again and again.
    """
    ended = False

    def end(*_: object) -> None:
        nonlocal ended
        ended = True
        if process is not None:
            process.terminate()

    process: subprocess.Popen[bytes] | None = None
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, end)
    log, failures = folder.path / "hub.log", 0
    announced = False
    while not ended:
        begun = time.monotonic()
        with log.open("ab") as out:
            process = subprocess.Popen(
                [sys.executable, "-m", HUB_MODULE, "--config", str(folder.config)],
                cwd=folder.path, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
                env=_environment(first=not announced), start_new_session=True,
            )  # fmt: skip
        if not announced and _answers(process, port):
            say(f"The teacher's wall: {link_of(address, key)}")
            say(f"BrickPose serves {len(students)} students at {address} (Ctrl-C ends it)")
            announced = True
        _wait(process, lambda: ended)
        end_services(folder.path, END_S)
        failures = failures + 1 if time.monotonic() - begun < WORSE_AFTER_S else 0
        if not ended and failures >= MOST_FAILURES:
            raise ClassError(f"JupyterHub ends at once; {log} says why")
    _end_servers(folder)
    return 0


def _wait(process: subprocess.Popen[bytes], ended: Callable[[], bool]) -> None:
    """Wait until the hub has ended; one that was told to and does not is killed."""
    asked: float | None = None
    while process.poll() is None:
        if ended() and asked is None:
            asked = time.monotonic()
        if asked is not None and time.monotonic() - asked > HUB_END_S:
            process.kill()
        time.sleep(LOOK_S)


def _answers(process: subprocess.Popen[bytes], port: int) -> bool:
    """Wait until the hub answers by its proxy; return whether it does, before it ends.

    However long it takes: on a busy computer that is more than a minute, and who serves a class
    without knowing its address has nothing.
    """
    opener = build_opener(ProxyHandler({}))
    while process.poll() is None:
        try:
            opener.open(f"http://127.0.0.1:{port}/hub/api/", timeout=ANSWER_S).close()
        except OSError:
            time.sleep(LOOK_S)
        else:
            return True
    return False


def _environment(*, first: bool) -> dict[str, str]:
    root = str(Path(__file__).parents[3])  # a checkout is not where JupyterHub looks
    path = os.environ.get("PYTHONPATH")
    sources = {"PYTHONPATH": f"{root}{os.pathsep}{path}" if path else root}
    return os.environ | sources | ({"BRICKPOSE_CLASS_STARTS": "1"} if first else {})


def _end_servers(folder: ClassFolder) -> None:
    """End the warm parent and what it started: the hub leaves them, so that it may die alone."""
    end_proxy(folder.path, END_S)
    end_copies(folder.warm_socket, END_S)
    end_others(folder.path, END_S)
