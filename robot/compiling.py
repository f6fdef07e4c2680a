"""The decorator of compiled functions: how numba compiles them, and where it keeps the result.

In compiled functions, three numbers are copied by a loop. For an array that is assigned to a slice,
and for ``np.where`` or ``np.outer``, numba compiles dozens of functions that fit shapes to each
other, which takes seconds.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit
from numba.core import caching

from robot.compiled_code import set_compile_cache

F = TypeVar("F", bound=Callable[..., Any])

CACHE = set_compile_cache()
"""Where compiled code is kept."""


class _OwnDataFiles(caching.IndexDataCacheFile):
    """Gives each process file names of its own.

    numba numbers the files of a function's versions. Two processes that compile different versions
    at the same time would take the same number, and one would then load the code of the other.
    """

    _own = uuid.uuid4().hex[:12]

    def _data_name(self, number: int) -> str:
        name, _, ending = super()._data_name(number).rpartition(".")  # type: ignore[no-untyped-call]
        return f"{name}-{self._own}.{ending}"


caching.IndexDataCacheFile = _OwnDataFiles  # type: ignore[misc]


def compiled(**options: Any) -> Callable[[F], F]:
    """Return a decorator that compiles a function at its first use, for its arguments' types.

    It is compiled without Python's lock, and kept for the next start if there is a folder for it.

    Args:
        options: further ones of ``numba.njit``.
    """
    kept = CACHE.folder is not None
    # Nobody calls these functions from C; the code for that would take a tenth of the time.
    options |= {"cache": kept, "nogil": True, "no_cfunc_wrapper": True}
    return njit(**options)  # type: ignore[no-any-return]
