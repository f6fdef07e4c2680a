"""Compiling, with progress on a terminal."""

from __future__ import annotations

from collections.abc import Callable

from tqdm import tqdm

from app.console import say
from app.engine.compiling.compilation import Compilation
from app.languages.marking import phrase


def compile_with_progress(
    compilation: Compilation, stop: Callable[[], bool] = lambda: False
) -> bool:
    """Compile, and say that and how far it is; return whether it was not stopped.

    Args:
        compilation: what is to be compiled.
        stop: says whether to stop soon.
    """
    if compilation.complaint:
        say(
            f"Compiling, at each start, about a minute: {compilation.complaint}; "
            "NUMBA_CACHE_DIR names another folder"
        )
    else:
        say(phrase("Compiling, once, about a minute ..."))
    with tqdm(total=compilation.total, unit="function", disable=None) as bar:
        return compilation.run(stop, lambda done: bar.update(done - bar.n))


def compile_first() -> None:
    """Compile if that is still to be done, before a command needs it."""
    compilation = Compilation()
    if compilation.needed:
        compile_with_progress(compilation)
