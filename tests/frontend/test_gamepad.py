"""A gamepad drives by its stick, and not by what browsers say of one that nobody has moved yet.

Some report an axis at its end until it is moved for the first time. Others have something else in
the stick's place that rests at its end, as a trigger. And browsers show a gamepad to pages when a
button of it is pressed, whichever.
"""

from __future__ import annotations

import pytest
from browsing import opened
from serving import serving, until

pytestmark = [pytest.mark.browser, pytest.mark.real_time]

PLUG = """([axes, pressed]) => {
  const buttons = Array.from({ length: 17 }, (_, i) => ({ pressed: i === pressed, value: 0 }));
  window.pad = { id: "Pad", index: 0, connected: true, mapping: "standard", axes, buttons };
  navigator.getGamepads = () => [null, window.pad];
  dispatchEvent(new Event("gamepadconnected"));
}"""
UNPLUG = """() => {
  navigator.getGamepads = () => [null, null];
  dispatchEvent(new Event("gamepaddisconnected"));
}"""
REST = [0.06, -0.08, 0, 0]
"""A worn stick that was let go."""
WAIT_S = 0.6


@pytest.fixture(scope="module")
def server():
    with serving("--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket


@pytest.fixture(scope="module")
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False)


@pytest.fixture
def plug(page):
    """Plug a gamepad in with axes and a pressed button, and unplug it in the end."""
    yield lambda axes, pressed=None: page.evaluate(PLUG, [axes, pressed])
    page.evaluate(UNPLUG)


def drives(now):
    return now["twist"]["v"] > 0.05


def require_idle(live):
    """It is idle soon, and stays so."""
    begun = until(live, lambda now: now["mode"] == "idle")["stamp"]
    now = until(live, lambda now: now["mode"] != "idle" or now["stamp"] > begun + WAIT_S)
    assert now["mode"] == "idle"


def move(page, axes):
    page.evaluate("(axes) => (window.pad.axes = axes)", axes)


@pytest.mark.parametrize("axes", [[0.99, 0.99, 0.99, 0.99], [0, -1, 0, 0], [-1, 0, 0, 0]])
def test_an_axis_that_is_first_seen_at_its_end_does_not_drive(page, plug, live, axes):
    plug(axes)
    require_idle(live)
    move(page, REST)
    require_idle(live)
    move(page, [0, -1, 0, 0])
    until(live, drives)
    move(page, REST)
    require_idle(live)


def test_a_gamepad_that_comes_back_must_be_at_rest_first(page, plug, live):
    plug(REST)
    require_idle(live)
    move(page, [0, -1, 0, 0])
    until(live, drives)
    page.evaluate(UNPLUG)
    require_idle(live)
    plug([0, -1, 0, 0])
    require_idle(live)


def test_the_button_that_makes_a_gamepad_known_begins_nothing(page, plug, live):
    plug(REST, 0)
    require_idle(live)
    page.evaluate("window.pad.buttons[0] = { pressed: false, value: 0 }")
    page.wait_for_timeout(200)
    page.evaluate("window.pad.buttons[0] = { pressed: true, value: 1 }")
    until(live, lambda now: now["mode"] == "figure_eight")
    page.evaluate("window.pad.buttons[1] = { pressed: true, value: 1 }")
    require_idle(live)
