"""Compiles all functions of the list by several processes, and says how far it is."""

from __future__ import annotations

import hashlib
import itertools
import logging
import sys
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, wait
from contextlib import ExitStack

import llvmlite.binding
import numba
from numba.core.bytecode import FunctionIdentity

from app.engine.compiling.functions import FUNCTIONS, Compiled
from app.engine.plugging import plugged
from app.worker_process import WorkerEndedError, WorkerProcess, cores
from robot.compiled_code import HERE, CompileCache
from robot.compiling import CACHE

LOG = logging.getLogger("brickpose")

MOST_WORKERS = 4
"""Each takes memory, and what several functions share is compiled by each worker."""

LOOK_S = 0.1
"""Interval of checking whether to stop [s]."""

OWN_NUMBERS = 1_000_000
"""numba numbers functions as a process meets them, and links code by these numbers. Code of several
workers is linked later, so each worker counts from a million of its own."""


class Compilation:
    """What is to be compiled on this computer; nothing, if it is kept from an earlier time."""

    def __init__(self, cache: CompileCache = CACHE) -> None:
        """Look whether everything is compiled."""
        self._functions = all_functions()
        self.total = len(self._functions)
        self.done = 0
        """How many functions are compiled; other threads may read it."""
        self.complaint = cache.complaint
        """Why compiled code cannot be kept; None if it is."""
        self._mark = None if cache.folder is None else cache.folder / f"complete-{_platform()}"

    @property
    def needed(self) -> bool:
        """Whether something is to be compiled, that is noted by no earlier start."""
        return not self._noted.issuperset(map(repr, self._functions))

    @property
    def _noted(self) -> set[str]:
        """The functions that earlier starts have compiled; other features may have taken part."""
        try:
            return set() if self._mark is None else set(self._mark.read_text("utf-8").splitlines())
        except OSError:
            return set()

    def run(
        self,
        stop: Callable[[], bool] = lambda: False,
        report: Callable[[int], object] = lambda done: None,
    ) -> bool:
        """Compile all functions; return whether it was not stopped.

        Where compiled code cannot be kept, other processes are of no use: this one compiles alone.

        Args:
            stop: says whether to stop soon.
            report: called after each function with the number that are done.
        """
        if self._mark is None:
            return self._alone(stop, report)
        try:
            complete = self._by_workers(stop, report)
        except (WorkerEndedError, OSError) as error:  # as without memory for them
            LOG.warning("Compiling by several processes failed (%s); one goes on.", error)
            complete = self._alone(stop, report)
        if complete:
            self.mark()
        return complete

    def mark(self) -> None:
        """Note for later starts that all is compiled."""
        assert self._mark is not None  # there is a folder for compiled code
        lines = sorted(self._noted.union(map(repr, self._functions)))
        try:
            self._mark.write_text("\n".join(lines), encoding="utf-8")
        except OSError as error:
            LOG.warning("What is compiled cannot be noted: %s", error)

    def _alone(self, stop: Callable[[], bool], report: Callable[[int], object]) -> bool:
        for done, function in enumerate(self._functions):
            self.done = done
            report(done)
            if stop():
                return False
            function.compile()
        self.done = self.total
        report(self.done)
        return True

    def _by_workers(self, stop: Callable[[], bool], report: Callable[[int], object]) -> bool:
        functions = iter(self._functions)
        with ExitStack() as stack:
            running = {}
            for number in range(1, min(cores(), MOST_WORKERS) + 1):
                worker = stack.enter_context(WorkerProcess())
                worker.submit(_count_from, number * OWN_NUMBERS)
                running[worker.submit(_compile, next(functions))] = worker
            while running:
                finished, _ = wait(running, LOOK_S, FIRST_COMPLETED)
                if stop():
                    return False
                for future in finished:
                    worker = running.pop(future)
                    future.result()
                    self.done += 1
                    report(self.done)
                    function = next(functions, None)
                    if function is not None:
                        running[worker.submit(_compile, function)] = worker
        return True


def all_functions() -> tuple[Compiled, ...]:
    """Return the core's functions and the features'.

    Those of a feature that fails here are compiled when they are called, if ever.
    """
    functions, _ = plugged().features.made(
        lambda feature: [function for make in feature.compiled for function in make()]
    )
    return (*FUNCTIONS, *functions)


def _compile(function: Compiled) -> None:
    function.compile()


def _count_from(first: int) -> None:
    FunctionIdentity._unique_ids = itertools.count(first)


def _platform() -> str:
    """Return a name for all that compiled code depends on, besides its sources."""
    cpu = llvmlite.binding
    parts = (
        sys.implementation.cache_tag,
        numba.__version__,
        cpu.get_host_cpu_name(),
        cpu.get_host_cpu_features().flatten(),
        HERE,  # two installations may share the user's folder, but not what is in it
    )
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:12]
