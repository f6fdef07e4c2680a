"""What the dashboard costs a browser: work a second, first page, bytes, and growth while open.

``python -m benchmarks.page_load [--minutes 10]`` needs Chromium; it draws without WebGL, as the 3D
view would measure the graphics card.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import CDPSession, Page, ViewportSize, sync_playwright

from benchmarks.programs import CHROMIUM, server

SIZE: ViewportSize = {"width": 1600, "height": 1000}
SECONDS = 20.0
LOOK_S = 30.0


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.page_load", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0, help="how long the page stays open")
    parser.add_argument("--url", help="a program that runs already")
    options = parser.parse_args()
    with _program(options.url) as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-3d-apis"]
        )
        first = browser.new_context(viewport=SIZE)
        _first_page(first.new_page(), url)
        # A page that stays open would work beside the one that is measured.
        first.close()
        page = browser.new_context(viewport=SIZE).new_page()
        _open(page, url)
        session = page.context.new_cdp_session(page)
        # On a busy machine, time that the thread waits is no work of it.
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        _work(page, session)
        _growth(page, session, 60 * options.minutes)
        browser.close()
    return 0


@contextmanager
def _program(url: str | None) -> Iterator[str]:
    if url is not None:
        yield url
        return
    with server("--map", "square", "--seed", "3") as running:
        yield running.url


def _open(page: Page, url: str) -> None:
    page.goto(url)
    page.wait_for_function("window.brickpose?.delays.length > 0", timeout=60_000)


def _first_page(page: Page, url: str) -> None:
    """Print our bytes before the first picture, and the time to it with a warm cache."""
    _open(page, url)
    own = page.evaluate(
        "performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))"
        ".filter((one) => !one.name.includes('/view/')).map((one) => one.encodedBodySize)"
    )
    print(f"bytes of our own: {sum(own) / 1000:.0f} kB in {len(own)} answers")
    begun = time.monotonic()
    _open(page, url)
    print(f"first picture, warm: {time.monotonic() - begun:.2f} s")


def _work(page: Page, session: CDPSession) -> None:
    """Print the share of a core that the page's thread works while the robot drives."""
    page.locator("#figure-eight").click()
    before, begun = _metrics(session), time.monotonic()
    shown = page.evaluate("window.brickpose.telemetry.stamp")
    page.wait_for_timeout(1000 * SECONDS)
    after, passed = _metrics(session), time.monotonic() - begun
    shown = page.evaluate("window.brickpose.telemetry.stamp") - shown
    for name in ("TaskDuration", "ScriptDuration", "LayoutDuration", "RecalcStyleDuration"):
        print(f"{name}: {100 * (after[name] - before[name]) / passed:.1f} % of a core")
    print(f"the robot drove {shown:.1f} s in {passed:.1f} s")


def _growth(page: Page, session: CDPSession, seconds: float) -> None:
    """Print how the heap and the page grow; garbage is collected before each look."""
    begun = time.monotonic()
    while True:
        session.send("HeapProfiler.collectGarbage")
        metrics = _metrics(session)
        minutes = (time.monotonic() - begun) / 60
        print(
            f"after {minutes:.1f} min: heap {metrics['JSHeapUsedSize'] / 1e6:.2f} MB, "
            f"{metrics['Nodes']:.0f} nodes, {metrics['JSEventListeners']:.0f} listeners",
            flush=True,
        )
        if time.monotonic() - begun >= seconds:
            return
        page.wait_for_timeout(1000 * min(LOOK_S, seconds))


def _metrics(session: CDPSession) -> dict[str, float]:
    answer = session.send("Performance.getMetrics")
    return {metric["name"]: metric["value"] for metric in answer["metrics"]}


if __name__ == "__main__":
    sys.exit(main())
