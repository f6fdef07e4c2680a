"""How long a step of the filter by hand takes, a step back, a particle asked, and a landscape.

``python -m benchmarks.by_hand`` asks as the page does: from the command, or the request, until the
answer is there. A step waits for the program's next tick, every 20 ms.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from urllib.request import urlopen

from websockets.sync.connection import Connection

from benchmarks.programs import ANSWER_S, START_S, estimated, server, until

ROUNDS = 20
MODELS = ("likelihood_field", "likelihood_field_prob", "beam")


def main() -> int:
    """Measure and print medians and the longest."""
    arguments = ["--map", "square", "--robot", "kinematic", "--seed", "3"]
    with server(*arguments) as running, running.live() as live:
        until(live, estimated, START_S)
        _send(live, type="set_parameters", values={"filter": "particles"})
        _send(live, type="scatter")
        _send(live, type="filter_by_hand", on=True)
        until(live, lambda news: news["filter"]["hand"] is not None)
        for name, commands in _rounds().items():
            _print(name, [_step(live, command) for command in commands])
        for model in MODELS:
            _send(live, type="set_parameters", values={"laser_model_type": model})
            _asks(running.url, model)
    return 0


def _rounds() -> dict[str, list[dict[str, str]]]:
    """Steps forwards and back, at 4000 particles."""
    steps = [{"type": "filter_step", "step": step} for step in ("predict", "weigh", "resample")]
    return {
        "step by hand": [command for _ in range(ROUNDS) for command in steps],
        "step back": [{"type": "filter_undo"}] * (3 * ROUNDS),
    }


def _step(live: Connection, command: dict[str, str]) -> float:
    """Time until telemetry tells that the step was taken [s]."""
    before = until(live, lambda _: True)["filter"]["hand"]["number"]
    began = time.perf_counter()
    live.send(json.dumps(command))
    until(live, lambda news: news["filter"]["hand"]["number"] > before)
    return time.perf_counter() - began


def _send(live: Connection, **command: object) -> None:
    live.send(json.dumps(command))
    time.sleep(0.5)  # so that what is measured next does not wait for it


def _asks(url: str, model: str) -> None:
    places = [0.01 * i for i in range(ROUNDS)]
    asked: dict[str, Callable[[float], str]] = {
        "a particle's rays": lambda x: f"/api/pose_fit?x={x}&y=0.1",
        "a pose's rays": lambda x: f"/api/pose_fit?x={x}&y=0.1&theta=0.5",
        "likelihood over x and y": lambda x: f"/api/likelihood?theta={x}",
        "likelihood over headings": lambda x: f"/api/likelihood/headings?x={x}&y=0.1",
    }
    for name, address in asked.items():
        _print(f"{name}, {model}", [_seconds(url + address(x)) for x in places])


def _seconds(address: str) -> float:
    began = time.perf_counter()
    with urlopen(address, timeout=ANSWER_S) as answer:
        answer.read()
    return time.perf_counter() - began


def _print(name: str, seconds: list[float]) -> None:
    median = sorted(seconds)[len(seconds) // 2]
    print(f"{name}: {1e3 * median:.0f} ms, longest {1e3 * max(seconds):.0f} ms", flush=True)


if __name__ == "__main__":
    sys.exit(main())
