"""Fences the process in which a student's code runs: limits, kernel, and Python's own events."""

from __future__ import annotations

import ctypes
import resource
import signal
import sys
import sysconfig
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from pathlib import Path
from types import ModuleType

from app.course.sandbox.audit import OWN, Watch
from app.course.sandbox.landlock import restrict_files
from app.course.sandbox.seccomp import refuse_calls

MEMORY = 2 * 1024**3
"""Address space of the process [bytes]; NumPy and numba take half of it."""
CPU_S = 30
"""Processor time of the whole process [s]; each call has a shorter limit, by the clock."""
FILES = 64
"""Most files that may be open."""
PACKAGES = ("numpy", "numpy.libs", "scipy", "scipy.libs", "numba", "llvmlite", "llvmlite.libs")
"""Packages that a student's code may import."""
STUDENT = "student"
"""The name of the module that the file becomes."""
DEATH_SIGNAL = 1


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


def confine() -> Watch:
    """Fence this process for good; return what notes the attempts to get out."""
    _end_with_parent()
    for limit, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CPU, CPU_S),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, FILES),
    ):
        resource.setrlimit(limit, (most, most))
    sys.dont_write_bytecode = True
    readable = _readable()
    # A path to the sources would let code import the answers; site-packages are named one by one.
    sys.path[:] = [path for path in sys.path if path in map(str, _roots())]
    sys.meta_path.insert(0, OnlyPackages())
    calls = refuse_calls()
    files = restrict_files(readable)
    return Watch(readable, kernel=calls and files)


def _end_with_parent() -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(DEATH_SIGNAL, signal.SIGKILL)


def _roots() -> list[Path]:
    paths = sysconfig.get_paths()
    library = Path(paths["stdlib"])
    return [library, library / "lib-dynload", Path(paths["purelib"]), Path(paths["platlib"])]


def _readable() -> list[Path]:
    """Return folders and files that may be read, by their real paths."""
    library, dynamic, *packages = _roots()
    allowed = [path for path in library.iterdir() if path.name != "site-packages"]
    allowed += [dynamic, *(root / name for root in packages for name in PACKAGES)]
    allowed += map(Path, ("/lib", "/lib64", "/usr/lib", "/usr/lib64", "/etc/ld.so.cache"))
    allowed += map(Path, ("/dev/null", "/dev/urandom", "/sys/devices/system/cpu", "/proc/cpuinfo"))
    return sorted({path.resolve() for path in allowed if path.exists()})
