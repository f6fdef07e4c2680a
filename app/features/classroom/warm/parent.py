"""WarmParent: it has imported and compiled all that a server needs, and forks one at each request.

A copy shares the parent's memory until one of them writes to it. The parent has one thread, so a
copy goes on as a program does that has just imported everything.
"""

from __future__ import annotations

import ctypes
import gc
import importlib
import json
import os
import pkgutil
import signal
import socket
import sys
import threading
import time
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.features.classroom.warm.confinement import MOST_FILE, confine
from app.features.classroom.warm.holes import fill_holes
from app.features.classroom.warm.request import ENDED, LONGEST, CopyRequest
from app.features.classroom.warm.serving import serve_once
from app.features.classroom.warm.watch import LOOK_S, ClassWatch

STEPS = 20
"""Ticks before, half of them driven, so that what is made at a first tick and at a first drive is
shared, too."""
ALONE_S = 10.0
THP_DISABLE = 41
"""``prctl``: no huge pages. NumPy asks for them, and a byte that is written then costs 2 MB."""
LOG = "brickpose.log"
ROOMS = ("app.engine", "app.page", "app.messages", "app.languages", "app.settings", "app.features")
COLD = (
    "app.features.build_hat",
    "app.features.classroom.hub",
    "app.features.classroom.warm.parent",
    "app.features.lab",
    "app.features.ros.dds",
    "app.features.course.lessons",
    "app.languages.extraction",
    "app.languages.update",
)
"""Rooms that servers of students do not enter."""
LATE = (
    "anyio._backends._asyncio",
    "app.__main__",
    "app.command_line",
    "app.tools.doctor.finding",
    "encodings.idna",
    "fastapi.telemetry._runtime",
    "multiprocessing.popen_fork",
    "pydantic.v1",
    "rich._emoji_codes",
    "rich.console",
    "rich.panel",
    "rich.table",
    "uvicorn.lifespan.on",
    "uvicorn.protocols.http.h11_impl",
    "uvicorn.protocols.websockets.websockets_sansio_impl",
    "viser.infra",
    "websockets.asyncio.server",
)
"""What libraries import only when they serve."""


class WarmParent:
    """Listens at a place in the file system that only its own user reaches."""

    def __init__(self, place: Path) -> None:
        self._place = place
        self._watch = ClassWatch()

    def serve(self) -> None:
        """Copy this process at each request; returns in a copy only, by ending it."""
        self._place.unlink(missing_ok=True)
        # The system buries copies that have ended; a hub asks for them by their numbers.
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
            mask = os.umask(0o077)
            listening.bind(str(self._place))
            os.umask(mask)
            listening.listen(64)
            next_look = time.monotonic() + LOOK_S
            while True:
                # Many who ask must not keep it from looking, nor the other way round.
                listening.settimeout(max(next_look - time.monotonic(), 0.0) or 0.001)
                connection = None
                with suppress(TimeoutError):
                    connection, _ = listening.accept()
                if time.monotonic() >= next_look:
                    self._watch.look()
                    next_look = time.monotonic() + LOOK_S
                if connection is None:
                    continue
                with connection:
                    connection.settimeout(5.0)
                    with suppress(OSError):
                        self._answer(connection, listening)

    def _answer(self, connection: socket.socket, listening: socket.socket) -> None:
        with connection.makefile("rb") as asked:
            line = asked.readline(LONGEST)
        if not line:
            return  # who only asks whether this is there
        try:
            request = CopyRequest.from_json(json.loads(line))
            confinement = request.confinement
            self._watch.clear(confinement, died=request.died)
            longest = self._watch.longest_file(confinement, MOST_FILE)
            why_ended = self._watch.ended.get(confinement.home, "")
            pid = os.fork()
        except (OSError, ValueError, TypeError, KeyError) as error:
            connection.sendall(json.dumps({"error": str(error)}).encode() + b"\n")
            return
        if not pid:
            listening.close()
            connection.close()
            _become(request, longest, why_ended)
        self._watch.begin(pid, confinement)
        connection.sendall(json.dumps({"pid": pid}).encode() + b"\n")


def _become(request: CopyRequest, longest_file: int, why_ended: str) -> None:
    """Be the program of a request, until it ends, and this process with it."""
    code = 1
    try:
        os.setsid()
        for each in (signal.SIGCHLD, signal.SIGTERM):
            signal.signal(each, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.environ.clear()
        os.environ.update({**request.environment, ENDED: why_ended})
        os.chdir(request.folder)
        confine(request.confinement, longest_file)
        _use_log(Path(request.folder, LOG))
        sys.argv = ["brickpose", *request.words]
        # By its name: it is above this room.
        code = importlib.import_module("app.__main__").main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _use_log(path: Path) -> None:
    out = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    for own in (1, 2):
        os.dup2(out, own)
    os.close(out)
    sys.stdout = os.fdopen(1, "w", buffering=1, closefd=False)
    sys.stderr = os.fdopen(2, "w", buffering=1, errors="backslashreplace", closefd=False)


def _import_all() -> None:
    """Import what servers import sooner or later: what a copy imports itself is its own memory."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for room in ROOMS:
            package = importlib.import_module(room)
            for module in pkgutil.walk_packages(package.__path__, f"{room}."):
                if not module.name.startswith(COLD):
                    with suppress(ImportError):  # of another system, or not installed
                        importlib.import_module(module.name)
        for name in LATE:
            importlib.import_module(name)


def get_warm() -> None:
    """Import what a server needs, drive a robot for a moment, and serve one to a page."""
    import cv2  # noqa: PLC0415 - its threads would not be in a copy

    cv2.setNumThreads(0)
    _import_all()
    from app.engine.build import build_program  # noqa: PLC0415
    from app.engine.plugging import plug_in  # noqa: PLC0415
    from app.feature_search import find_features  # noqa: PLC0415
    from app.features.control.starting import share_with_forks  # noqa: PLC0415
    from app.features.course.learn_command import suited  # noqa: PLC0415
    from app.messages.driving_commands import DriveCommand  # noqa: PLC0415
    from app.settings.config import Config  # noqa: PLC0415

    plug_in(find_features())
    for robot in ("kinematic", "auto"):
        config = suited(Config(robot=robot), 1, map_given=False)
        program: Any = build_program(config)
        for tick in range(STEPS):
            if tick >= STEPS // 2:
                program.engine.commands.put(DriveCommand(type="drive", v=0.1, omega=0.5))
            program.engine.step()
        program.robot.close()
        share_with_forks(program)
    serve_once()
    end = time.monotonic() + ALONE_S
    while len(list(Path("/proc/self/task").iterdir())) > 1:
        if time.monotonic() > end:
            raise RuntimeError(f"threads that a copy would not have: {threading.enumerate()}")
        time.sleep(0.01)
    gc.collect()
    gc.freeze()


if __name__ == "__main__":
    ctypes.CDLL(None).prctl(THP_DISABLE, 1, 0, 0, 0)  # copies inherit it
    get_warm()
    held = fill_holes()  # for as long as copies are made
    WarmParent(Path(sys.argv[1])).serve()
