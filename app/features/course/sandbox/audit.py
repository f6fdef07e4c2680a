"""Python's own events: what the code tries is refused and noted, with words for the student.

It is the only fence where the kernel has none (macOS, Windows), and a weaker one.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from robot.errors import BrickPoseError

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
OWN = ("app", "robot", "sim", "benchmarks")
"""Packages that hold the answers."""

FILES = "changes files"
PROCESSES = "starts another program"
NETWORK = "asks the network"
READS = "reads the file "
SIGNALS = "sends signals to other programs"
EVENTS = {
    **dict.fromkeys(["os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.truncate"], FILES),
    **dict.fromkeys(["os.link", "os.symlink", "os.chmod", "os.chown", "os.utime"], FILES),
    **dict.fromkeys(["os.fork", "os.forkpty", "os.exec", "os.posix_spawn", "os.spawn"], PROCESSES),
    **dict.fromkeys(["os.system", "subprocess.Popen", "os.startfile", "pty.spawn"], PROCESSES),
    **dict.fromkeys(["os.kill", "os.killpg", "signal.pthread_kill"], SIGNALS),
    **dict.fromkeys(["_winapi.OpenProcess", "_winapi.TerminateProcess"], SIGNALS),
    **dict.fromkeys(["_winapi.CreateProcess", "os.startfile/2"], PROCESSES),
    **dict.fromkeys(["_winapi.CreateJunction"], FILES),
    **dict.fromkeys(["winreg.CreateKey", "winreg.DeleteKey", "winreg.SetValue"], FILES),
    **dict.fromkeys(["winreg.DeleteValue", "winreg.SaveKey", "winreg.LoadKey"], FILES),
}
"""What each event means, to tell the student."""


class RefusedError(BrickPoseError, PermissionError):
    """The code tried something that no lesson needs."""


class Watch:
    """Refuses what reaches beyond the process, and keeps the first attempt."""

    def __init__(self, readable: Sequence[Path], *, kernel: bool) -> None:
        """Start watching, for the rest of the process.

        Args:
            readable: files below these may be read.
            kernel: whether the kernel fences the process as well; without it, C code is refused.
        """
        self.attempt: str | None = None
        """What the code tried first, in words; None while it has tried nothing."""
        self._readable = tuple(os.path.normcase(f"{path}{os.sep}") for path in readable)
        self._kernel = kernel
        sys.addaudithook(self._hook())

    def _hook(self) -> Callable[[str, tuple[object, ...]], None]:
        def hook(event: str, arguments: tuple[object, ...]) -> None:
            words = self._refusal(event, arguments)
            if words is not None:
                # Libraries ask for files that they can do without; that alone is no attempt.
                if not words.startswith(READS):
                    self.attempt = self.attempt or words
                raise RefusedError(f"no lesson needs this: the code {words}")

        return hook

    def _refusal(self, event: str, arguments: tuple[object, ...]) -> str | None:
        if event == "open":
            return self._opening(arguments)
        if event == "import":
            name = str(arguments[0]).partition(".")[0]
            if name == "ctypes" and not self._kernel:
                return "loads C code"
            return "reads the program's own code" if name in OWN else None
        if event.startswith("socket.") and event not in ("socket.gethostname",):
            return NETWORK
        return EVENTS.get(event)

    def _opening(self, arguments: tuple[object, ...]) -> str | None:
        path, _, flags = arguments
        if isinstance(path, int):
            return None
        if isinstance(flags, int) and flags & WRITING:
            return FILES
        place = os.path.realpath(os.fsdecode(path))  # type: ignore[arg-type]
        inside = os.path.normcase(f"{place}{os.sep}").startswith(self._readable)
        return None if inside else READS + place
