"""A simulated robot with its server in this process, whose step times can be read."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from app.engine.build import build_program
from app.page.listening import listen
from app.page.serving import Server
from app.settings.config import Config
from sim.real_time import RealTime

WARM_UP_S = 5.0
"""Time in which compiled code is loaded, and the first large clouds are over."""


@contextmanager
def served_simulation() -> Iterator[tuple[str, RealTime]]:
    """Serve a simulated robot; yield its address (host:port) and its pace, once it is warm."""
    pace = RealTime()
    program = build_program(Config(robot="sim"), pace)
    listening = listen("127.0.0.1", 0)
    server = Server(program)
    thread = threading.Thread(target=server.run, args=(listening,), name="server")
    thread.start()
    try:
        with program.engine.audience.joined():  # or the camera rests while there are no clients
            time.sleep(WARM_UP_S)
            yield f"127.0.0.1:{listening.getsockname()[1]}", pace
    finally:
        server.stop()
        thread.join(10)


def percentile_ms(pace: RealTime, percent: float) -> float:
    """Return a percentile of the step times since ``pace.busy`` was cleared [ms]."""
    return 1e3 * float(np.percentile(list(pace.busy), percent))
