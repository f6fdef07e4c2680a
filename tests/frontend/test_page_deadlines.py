"""What the page in a real Chromium has to do in time: show, stop, recover."""

import json
import math

import numpy as np
import pytest
from browsing import opened
from playwright.sync_api import Page
from serving import pose_error, serving, stamp_now, until

pytestmark = [pytest.mark.browser, pytest.mark.real_time]


@pytest.fixture(scope="module")
def server():
    with serving("--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


def test_from_exposure_to_pixel(page):
    page.get_by_role("button", name="Figure-eight").click()
    page.evaluate("window.brickpose.delays.length = 0")
    page.wait_for_function("window.brickpose.delays.length >= 180", timeout=30_000)
    delays = np.array(page.evaluate("window.brickpose.delays.slice(-150)"))
    page.get_by_role("button", name="STOP").first.click()
    print(
        f"\nexposure to pixel: median {np.median(delays):.0f} ms,"
        f" p95 {np.percentile(delays, 95):.0f} ms"
    )
    # The figure itself depends on how busy this machine is; what must hold is the order of it.
    assert 10 < np.median(delays) < 200


@pytest.mark.parametrize("leave", ["close", "hide", "blur"])
def test_when_the_page_goes_away_the_robot_stops_within_half_a_second(page, server, live, leave):
    page.keyboard.down("w")
    until(live, lambda now: now["twist"]["v"] > 0.1)
    if leave == "close":
        page.close()
    elif leave == "hide":
        page.evaluate(
            """() => { Object.defineProperty(document, 'visibilityState', {value: 'hidden'});
                       Object.defineProperty(document, 'hidden', {value: true});
                       document.dispatchEvent(new Event('visibilitychange')); }"""
        )
    else:
        page.evaluate("window.dispatchEvent(new Event('blur'))")
    left = stamp_now(server)
    still = until(live, lambda now: now["twist"]["v"] == 0)
    assert still["stamp"] - left <= 0.5


def test_when_the_network_dies_the_robot_stops_within_half_a_second(page, server, live):
    page.keyboard.down("w")
    until(live, lambda now: now["twist"]["v"] > 0.1)
    # Nothing is sent or closed any more, as when the cable is pulled.
    page.evaluate("WebSocket.prototype.send = () => {}")
    dead = stamp_now(server)
    still = until(live, lambda now: now["twist"]["v"] == 0)
    assert still["stamp"] - dead <= 0.55


def heading_error(now: dict) -> float:
    return abs(math.remainder(now["estimate"]["theta"] - now["truth"]["theta"], 2 * math.pi))


def drag(page: Page, start: tuple[float, float], heading: float) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move(start[0] + 40 * math.cos(heading), start[1] - 40 * math.sin(heading), steps=4)
    page.mouse.up()


def test_a_wrong_pose_set_by_drag_is_recovered_from(page, live):
    """(-0.1 m, -0.1 m, 0.3 rad) off, while driving the figure-eight; right within 4 s."""
    live.send(json.dumps({"type": "place", "x": 0, "y": 0, "theta": 0}))
    live.send(json.dumps({"type": "set_pose", "x": 0, "y": 0, "theta": 0}))
    page.locator("[data-tool=set_pose]").click()
    page.get_by_role("button", name="Figure-eight").click()
    before = until(live, lambda now: now["twist"]["v"] > 0.1 and pose_error(now) < 0.02)
    truth = before["truth"]
    start = page.evaluate(f"window.brickpose.mapPixel({truth['x'] - 0.1}, {truth['y'] - 0.1})")
    drag(page, start, truth["theta"] + 0.3)
    lost = until(live, lambda now: pose_error(now) > 0.05)
    found = until(live, lambda now: pose_error(now) < 0.02 and heading_error(now) < 0.1, 4.0)
    print(f"\nwrong pose by drag: right again after {found['stamp'] - lost['stamp']:.2f} s")
    held = until(live, lambda now: now["stamp"] > found["stamp"] + 1)
    assert pose_error(held) < 0.02
