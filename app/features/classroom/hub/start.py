"""Starts JupyterHub, without what it imports and never uses; one that is killed is begun again.

To import it takes a second of a core, for which a class waits whose hub was killed. So this process
imports it, and the hub is a copy of it (``fork``), as students' servers are of theirs.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from app.features.classroom.warm.ending import end_services

UNUSED = "rfc3987_syntax"
"""A format of JSON that the hub's own events do not have. It builds a grammar when it is imported:
half of the 2.5 s of a core that a hub needs to start, for which a class waits whose hub was
killed."""
FIRST_START = "BRICKPOSE_CLASS_STARTS"
WORSE_AFTER_S = 10.0
"""A hub that lives shorter [s] is not begun again here: who has started this counts those."""
END_S = 4.0
DIES_WITH_PARENT = 1


def main() -> None:
    """Be JupyterHub, by its own command line."""
    sys.modules[UNUSED] = None  # type: ignore[assignment] # to import it is an ImportError then
    from jupyterhub.app import main as serve  # noqa: PLC0415 - after that

    if sys.platform != "linux":
        serve()
        return
    gc.collect()
    gc.freeze()
    raise SystemExit(keep_begun(serve, Path(sys.argv[sys.argv.index("--config") + 1]).parent))


def keep_begun(serve: Callable[[], object], folder: Path) -> int:
    """Serve by copies of this process until one ends that was not killed; return how it ended.

    Args:
        serve: what a copy does.
        folder: the class's, whose services end with each copy.
    """
    ended = False
    pid = 0

    def end(number: int, _: object) -> None:
        nonlocal ended
        ended = True
        if pid:
            os.kill(pid, number)

    signs = (signal.SIGTERM, signal.SIGINT)
    for each in signs:
        signal.signal(each, end)
    while True:
        begun = time.monotonic()
        signal.pthread_sigmask(signal.SIG_BLOCK, signs)
        pid = os.fork()
        if not pid:
            for each in signs:
                signal.signal(each, signal.default_int_handler)
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, signs)
            serve()
            return 0
        signal.pthread_sigmask(signal.SIG_UNBLOCK, signs)
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        pid = 0
        if ended or code >= 0 or time.monotonic() - begun < WORSE_AFTER_S:
            return code if code >= 0 else 1
        os.environ.pop(FIRST_START, None)
        end_services(folder, END_S)


if __name__ == "__main__":
    main()
