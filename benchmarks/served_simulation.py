"""A simulated robot with its server in this process, and how late its ticks are."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import numpy as np

from app.engine.mailboxes.backlog import Backlog
from app.engine.plugging import plug_in
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.feature_search import find_features
from app.messages.driving_commands import FigureEightCommand
from app.page.listening import listen
from app.page.serving import Server, build_served
from app.settings.config import Config
from sim.simulated import PERIOD

WARM_UP_S = 5.0
"""Time in which compiled code is loaded, and the first large clouds are over."""
MOST_TICKS = 20_000


class Ticks:
    """When ticks were published, by the one clock that all processes have.

    A tick is published when its commands were taken and the wheels were told. A simulated robot has
    a fixed schedule: what a tick comes later after its stamp than the most punctual one, was lost
    to physics and to others that use the same processor, or the same lock.
    """

    def __init__(self, every: Backlog[Snapshot]) -> None:
        self._every = every

    def delays(self, seconds: float) -> np.ndarray:
        """Return the delays of the ticks of the next seconds (n,) [s].

        Where the loop stood, the ticks that were due meanwhile are as late as the one after them,
        or at least as the end of these seconds.
        """
        self._taken()
        time.sleep(seconds)
        ticks = self._taken()
        if not ticks:  # the loop stood all the time: each tick that was due is late until its end
            return np.arange(PERIOD, seconds, PERIOD)
        delays = np.array([published - stamp for stamp, published in ticks])
        times = np.array([published for _, published in ticks])
        lost = [np.arange(PERIOD, gap - 1.5 * PERIOD, PERIOD) for gap in np.diff(times)]
        return np.concatenate([delays - delays.min(), *lost])

    def percentile_ms(self, percent: float, seconds: float) -> float:
        """Return a percentile of the delays of the next seconds' ticks [ms]."""
        return 1e3 * float(np.percentile(self.delays(seconds), percent))

    def _taken(self) -> list[tuple[float, float]]:
        return [(tick.stamp, tick.published) for tick in iter(self._every.get, None)]


@contextmanager
def served_simulation(*, one_process: bool = False) -> Iterator[tuple[str, Ticks, Program]]:
    """Serve a robot that drives; yield its address (host:port), its ticks, and the program.

    Args:
        one_process: whether the robot is driven in this process, which also serves.
    """
    plug_in(find_features())
    config = Config(robot="sim", added={"control": {"one_process": one_process}})
    program = build_served(config)
    listening = listen("127.0.0.1", 0)
    server = Server(program)
    thread = threading.Thread(target=server.run, args=(listening,), name="server")
    thread.start()
    over = threading.Event()
    driver = threading.Thread(target=_drive, args=(program, over), name="driver")
    try:
        with program.engine.every.subscribe(MOST_TICKS) as every:
            driver.start()
            time.sleep(WARM_UP_S)
            yield f"127.0.0.1:{listening.getsockname()[1]}", Ticks(every), program
    finally:
        over.set()
        with suppress(RuntimeError):  # it was not begun
            driver.join()
        server.stop()
        thread.join(10)


@contextmanager
def in_a_thread(work: Callable[[], object]) -> Iterator[None]:
    """Do work again and again in a thread of this process, until the block ends."""
    over = threading.Event()

    def repeat() -> None:
        while not over.is_set():
            work()

    thread = threading.Thread(target=repeat, name="disturbance")
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _drive(program: Program, over: threading.Event) -> None:
    """Drive the figure-eight until it is over."""
    while not over.wait(0.1):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
