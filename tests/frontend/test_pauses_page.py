"""What the robot drives by itself goes on after a moment without its page, or says why not."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest
from breakable_wire import BreakableWire, breakable
from browsing import opened
from playwright.sync_api import Page, expect
from serving import ask, serving, stamp_now, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]

BLOCK = "() => { const t = performance.now(); while (performance.now() - t < 1500); }"
HIDE = """() => { Object.defineProperty(document, 'hidden', {value: true, configurable: true});
                   document.dispatchEvent(new Event('visibilitychange')); }"""
SHOW = """() => { Object.defineProperty(document, 'hidden', {value: false, configurable: true});
                   document.dispatchEvent(new Event('visibilitychange')); }"""
LOSS_S = 2.0
MODES = {"explore": "explore", "calibrate": "calibrate", "figure-eight": "figure_eight"}


@pytest.fixture(scope="module")
def server():
    with serving("--map", "stub", "--condition", "hand-built", "--seed", "3") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket


@pytest.fixture
def wired(browser, server) -> Iterator[tuple[Page, BreakableWire]]:
    with breakable(server) as (wire, near):
        with server.live() as socket:
            for command in ("discard_map", "reset", "take"):
                ask(socket, type=command)
        for page in opened(browser, near, width=1100, height=760, view=False):
            yield page, wire


def start(page: Page, what: str) -> None:
    if what == "explore":
        page.locator("#mapping-open").click()
        page.locator("#mapping-explore").click()
    elif what == "calibrate":
        page.locator("#calibration-open").click()
        page.locator("#calibration-drive").click()
    else:
        page.locator("#figure-eight").click()


def moves(now: dict) -> bool:
    return abs(now["twist"]["v"]) > 0.02 or abs(now["twist"]["omega"]) > 0.1


@pytest.mark.parametrize("pause", ["busy", "silent", "cut"])
@pytest.mark.parametrize("what", list(MODES))
def test_it_stands_for_a_moment_and_goes_on(wired, live, what, pause) -> None:
    page, wire = wired
    start(page, what)
    until(live, lambda now: now["mode"] == MODES[what] and moves(now))
    if pause == "busy":
        # The block's end is not waited for: this reads what the robot does meanwhile.
        page.evaluate(f"() => void setTimeout({BLOCK})")
    elif pause == "silent":
        wire.hold_up()
    else:
        wire.cut()
    begun = time.monotonic()
    still = until(live, lambda now: not moves(now) and now["twist"]["v"] == 0)
    assert still["mode"] == MODES[what]
    until(live, lambda now: pause == "busy" or time.monotonic() - begun > LOSS_S)
    wire.mend()
    page.wait_for_function("window.brickpose.connected")
    on = until(live, lambda now: moves(now) or now["mode"] != MODES[what])
    assert on["mode"] == MODES[what]
    later = until(live, lambda now: now["stamp"] > on["stamp"] + 1)
    assert later["mode"] == MODES[what]
    assert page.locator("#toasts .note").count() == 0
    page.locator("#stop").click()
    until(live, lambda now: now["mode"] == "idle")


def test_what_was_stopped_meanwhile_does_not_go_on_and_the_page_says_so(
    wired, server, live
) -> None:
    page, wire = wired
    start(page, "figure-eight")
    until(live, lambda now: now["mode"] == "figure_eight" and moves(now))
    wire.hold_up()
    until(live, lambda now: now["twist"]["v"] == 0)
    assert ask(live, type="stop")["type"] == "ack"
    stopped = stamp_now(server)
    until(live, lambda now: now["stamp"] > stopped + 1.2)
    wire.mend()
    expect(page.locator("#toasts")).to_contain_text(
        "The figure-eight ended: somebody stopped the robot."
    )
    now = stamp_now(server)
    assert until(live, lambda tick: tick["stamp"] > now + 0.5)["mode"] == "idle"


def test_a_page_that_was_hidden_says_what_ended_and_goes_on_by_a_press(wired, live) -> None:
    page, _ = wired
    start(page, "explore")
    until(live, lambda now: now["mode"] == "explore" and moves(now))
    page.evaluate(HIDE)
    until(live, lambda now: now["mode"] == "idle")
    page.evaluate(SHOW)
    toast = page.locator("#toasts .toast")
    expect(toast).to_contain_text("Exploring ended: this page was hidden.")
    toast.get_by_role("button", name="go on").click()
    until(live, lambda now: now["mode"] == "explore" and moves(now))
    expect(toast).to_have_count(0)
    page.locator("#stop").click()


def test_after_a_long_pause_the_page_says_so(wired, live) -> None:
    page, wire = wired
    start(page, "figure-eight")
    until(live, lambda now: now["mode"] == "figure_eight" and moves(now))
    wire.hold_up()
    until(live, lambda now: now["mode"] == "idle")
    wire.mend()
    expect(page.locator("#toasts")).to_contain_text("paused for too long")
    expect(page.locator("#figure-eight")).to_have_attribute("aria-pressed", "false")
