"""Fences the process in which a student's code runs: limits, kernel, and Python's own events."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import sysconfig
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from pathlib import Path
from types import ModuleType

from app.features.course.sandbox.audit import OWN, Watch
from app.features.course.sandbox.landlock import restrict_files
from app.features.course.sandbox.limits import limit_this_process
from app.features.course.sandbox.own_user import leave_root
from app.features.course.sandbox.seccomp import refuse_calls

PACKAGES = ("numpy", "numpy.libs", "scipy", "scipy.libs", "numba", "llvmlite", "llvmlite.libs")
"""Packages that a student's code may import."""
STUDENT = "student"
"""The name of the module that the file becomes."""
DEATH_SIGNAL = 1
KERNEL = frozenset(("Landlock", "seccomp"))
"""The fences of Linux's kernel."""


class OnlyPackages(MetaPathFinder):
    """Finds nothing; other packages than those allowed are said to be missing.

    Libraries ask for others that they can do without, and take only this for an answer.
    """

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> None:
        """Leave the standard library and the allowed packages to Python."""
        first = name.partition(".")[0]
        if first not in sys.stdlib_module_names and first not in (*PACKAGES, *OWN, STUDENT):
            raise ModuleNotFoundError(f"lessons run without {first}", name=name)


def confine() -> tuple[Watch, list[str]]:
    """Fence this process for good; return what notes the attempts to get out, and the fences."""
    limit_this_process()
    sys.dont_write_bytecode = True
    readable = _readable()
    # A path to the sources would let code import the answers; site-packages are named one by one.
    roots = {os.path.normcase(path) for path in _roots()}
    sys.path[:] = [path for path in sys.path if os.path.normcase(path) in roots]
    sys.meta_path.insert(0, OnlyPackages())
    files = restrict_files(readable)
    user = leave_root(readable, fenced=files)
    _end_with_parent()  # whoever changes its user has to ask for it anew
    calls = refuse_calls()  # last: what came before is refused from here on
    fences = _fences(calls=calls, files=files, user=user)
    return Watch(readable, kernel=calls and files), fences


def _fences(*, calls: bool, files: bool, user: bool) -> list[str]:
    """Return what holds this process, in words for the doctor."""
    limits = "a job of Windows" if sys.platform == "win32" else "limits of the system"
    kernel = {"Landlock": files, "seccomp": calls, "a user of its own": user}
    return [*(name for name, done in kernel.items() if done), limits, "Python's own events"]


def _end_with_parent() -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def _roots() -> list[Path]:
    paths = sysconfig.get_paths()
    library = Path(paths["stdlib"])
    compiled = library / "lib-dynload", Path(sys.base_prefix, "DLLs")  # Unix; Windows
    return [library, *compiled, Path(paths["purelib"]), Path(paths["platlib"])]


def _readable() -> list[Path]:
    """Return folders and files that may be read, by their real paths."""
    library, *compiled, pure, platform = _roots()
    allowed = [path for path in library.iterdir() if path.name != "site-packages"]
    allowed += [*compiled, *(root / name for root in (pure, platform) for name in PACKAGES)]
    allowed += map(Path, ("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/etc/ld.so.cache"))
    allowed += map(Path, (os.devnull, "/dev/urandom", "/sys/devices/system/cpu", "/proc/cpuinfo"))
    return sorted({path.resolve() for path in allowed if path.exists()})
