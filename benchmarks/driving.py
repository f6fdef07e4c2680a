"""Benchmark of what a robot costs that drives, with no page, one and further ones, or stands."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager

from websockets.asyncio.client import connect

from benchmarks.programs import ServedProgram, server
from benchmarks.result import Result

PAGES = 5
"""Pages of the largest number that is measured; a further one costs their mean."""
WARM_UP_S = 10.0
"""Time until compiled code is loaded, and garbage collection has its rhythm [s]."""
SECONDS = 20.0
"""Time over which each number of pages is measured [s]."""
SETTLE_S = 2.0
CIRCLE = {"twist": {"linear": {"x": 0.12}, "angular": {"z": 0.45}}}
"""A circle of 0.27 m, which every field of ours has room for."""


def measure() -> Result:
    """Measure shares of a core, by the processor time of the program's processes, and memory."""
    more: dict[str, float] = {}
    for robot in ("kinematic", "sim"):
        with server("--robot", robot, "--map", "square", "--seed", "3") as running:
            more |= {f"{name}, {robot}": value for name, value in _measured(running).items()}
    return Result(
        unit="% of a core with one page and the camera's stream",
        brickpose=more["one page [%], kinematic"],
        more=more,
    )


def _measured(running: ServedProgram) -> dict[str, float]:
    with meanwhile(page(running.address)):
        time.sleep(WARM_UP_S)  # meanwhile it comes to rest
        stands = share(running)
    with meanwhile([drive(running.address)]):
        time.sleep(WARM_UP_S)
        nobody = share(running)
        with meanwhile(page(running.address)):
            alone, memory = share(running), running.memory_mb()
        with meanwhile([part for _ in range(PAGES) for part in page(running.address)]):
            several = share(running)
    return {
        "nobody [%]": nobody,
        "one page [%]": alone,
        "stands, one page [%]": stands,
        "each further page [%]": (several - alone) / (PAGES - 1),
        "memory with one page [MB]": memory,
    }


def share(running: ServedProgram) -> float:
    """Return the program's share of a core [%]."""
    time.sleep(SETTLE_S)
    before, start = running.processor_seconds(), time.perf_counter()
    time.sleep(SECONDS)
    return 100 * (running.processor_seconds() - before) / (time.perf_counter() - start)


async def drive(address: str) -> None:
    """Drive as a program of ROS does that looks at nothing; a socket for pages would look."""
    async with connect(f"ws://{address}/rosbridge", compression=None) as socket:
        kind = "geometry_msgs/msg/TwistStamped"
        await socket.send(json.dumps({"op": "advertise", "topic": "/cmd_vel", "type": kind}))
        while True:
            await socket.send(json.dumps({"op": "publish", "topic": "/cmd_vel", "msg": CIRCLE}))
            await asyncio.sleep(0.1)


def page(address: str) -> list[Coroutine[None, None, None]]:
    """Receive what a page does that shows the map and the camera."""
    return [receive(f"ws://{address}/api/{path}") for path in ("live?rate=30", "camera")]


async def receive(address: str) -> None:
    """Take whatever comes through a socket."""
    async with connect(address, max_size=None, compression=None) as socket:
        async for _ in socket:
            pass


@contextmanager
def meanwhile(work: list[Coroutine[None, None, None]]) -> Iterator[None]:
    """Let clients work in a thread of this process until the block ends.

    Raises:
        ConnectionClosed, OSError: one of them has failed.
    """
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, name="clients")
    thread.start()
    clients = [asyncio.run_coroutine_threadsafe(each, loop) for each in work]
    try:
        yield
        for client in clients:
            if client.done():
                client.result()
    finally:
        for client in clients:
            client.cancel()
        asyncio.run_coroutine_threadsafe(_ended(), loop).result(10)
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


async def _ended() -> None:
    """Wait for all other tasks of this loop."""
    others = asyncio.all_tasks() - {asyncio.current_task()}
    await asyncio.gather(*others, return_exceptions=True)
