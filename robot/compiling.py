"""The decorator of compiled functions: how numba compiles them, and where it keeps the result.

In compiled functions, three numbers are copied by a loop. For an array that is assigned to a slice,
and for ``np.where`` or ``np.outer``, numba compiles dozens of functions that fit shapes to each
other, which takes seconds.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding as llvm
from numba import njit
from numba.core import caching, codegen
from numba.core.runtime.nrt import rtsys

from robot.compiled_code import set_compile_cache

F = TypeVar("F", bound=Callable[..., Any])

CACHE = set_compile_cache()
"""Where compiled code is kept."""


class _KeptLibrary(codegen.JITCodeLibrary):
    """Leaves the intermediate code of a kept function unread, until a caller of it is compiled.

    Machine code is all that a call needs. numba reads the intermediate code at once, only to learn
    the names in it; that takes longer than all else of a function, and more memory. So the names
    are kept as well.
    """

    _unread: bytes = b""

    def serialize_using_object_code(self) -> tuple[str, str, tuple[bytes, bytes, tuple[str, ...]]]:
        name, kind, (machine_code, intermediate) = super().serialize_using_object_code()  # type: ignore[no-untyped-call]
        module = self._get_module_for_linking()
        names = (
            each.name
            for each in (*module.functions, *module.global_variables)
            if not each.is_declaration
        )
        return name, kind, (machine_code, intermediate, tuple(names))

    @classmethod
    def _unserialize(cls, owner: Any, state: Any) -> _KeptLibrary:
        name, _, (machine_code, intermediate, names) = state
        library = cls(owner, name)
        library.enable_object_caching()  # type: ignore[no-untyped-call]
        library._set_compiled_object(machine_code)  # type: ignore[no-untyped-call]
        library._unread = intermediate
        library._finalize_final_module()  # type: ignore[no-untyped-call]
        owner._engine._defined_symbols.update(names)
        return library

    def _get_module_for_linking(self) -> Any:
        if self._unread:
            self._shared_module, self._unread = llvm.parse_bitcode(self._unread), b""
        return super()._get_module_for_linking()  # type: ignore[no-untyped-call]


codegen.JITCPUCodegen._library_class = _KeptLibrary


class _OwnDataFiles(caching.IndexDataCacheFile):
    """Gives each process file names of its own.

    numba numbers the files of a function's versions. Two processes that compile different versions
    at the same time would take the same number, and one would then load the code of the other.
    """

    _own = uuid.uuid4().hex[:12]

    def _data_name(self, number: int) -> str:
        name, _, ending = super()._data_name(number).rpartition(".")  # type: ignore[no-untyped-call]
        return f"{name}-{self._own}.{ending}"


class _OneFolder(caching.UserProvidedCacheLocator):
    """Finds the folder, without a trial for each function whether it can be written to."""

    def ensure_cache_path(self) -> None:
        Path(self._cache_path).mkdir(parents=True, exist_ok=True)


class _Versions(caching.CompileResultCacheImpl):
    """Packs and unpacks the versions of a function."""

    _locator_classes: list[type[object]] = [_OneFolder]  # noqa: RUF012 - as numba has it


class _KeptVersions(caching.FunctionCache):
    """Loads kept code without all that numba knows of Python and NumPy.

    Only the compiler needs that, and asks for it itself.
    """

    _impl_class = _Versions

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _OwnDataFiles(self._cache_path, self._impl.filename_base, stamp)  # type: ignore[no-untyped-call]

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        # Code that makes arrays calls numba's memory, which begins with the first function.
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]


def compiled(**options: Any) -> Callable[[F], F]:
    """Return a decorator that compiles a function at its first use, for its arguments' types.

    It is compiled without Python's lock, and kept for the next start if there is a folder for it.

    Args:
        options: further ones of ``numba.njit``.
    """
    # Nobody calls these functions from C; the code for that would take a tenth of the time.
    options |= {"nogil": True, "no_cfunc_wrapper": True}
    decorate = njit(**options)

    def wrapped(function: F) -> F:
        dispatcher: Any = decorate(function)
        if CACHE.folder is not None:
            dispatcher._cache = _KeptVersions(function)
        return dispatcher  # type: ignore[no-any-return]

    return wrapped
