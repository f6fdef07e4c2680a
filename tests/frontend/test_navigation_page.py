"""Goals on the map: a drag sends the robot there, and the page says how far it is."""

import math
import re

import pytest
from browsing import opened, show_all
from playwright.sync_api import expect
from serving import ask, serving, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]

GOAL = (0.2, 0.15)
ARRIVED = re.compile("^goal: arrived(; its (place|heading) is known to .* only)?$")


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "sim", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1200, height=800, view=False)


def drag(page, start, end):
    """Press at a place on the map [m], drag to another one, release."""
    (u, v), (to_u, to_v) = (
        page.evaluate("([x, y]) => window.brickpose.mapPixel(x, y)", list(place))
        for place in (start, end)
    )
    page.mouse.move(u, v)
    page.mouse.down()
    page.mouse.move(to_u, to_v, steps=4)
    page.mouse.up()


def test_a_drag_on_the_map_sends_the_robot_there_and_it_arrives(page, server):
    page.get_by_role("button", name="go to", exact=True).first.click()
    expect(page.locator("#planning")).to_be_visible()  # it moves the map
    drag(page, GOAL, (GOAL[0], GOAL[1] + 0.2))
    expect(page.locator("#journey-text")).to_contain_text("left")
    expect(page.locator("#journey-text")).to_have_text(ARRIVED)
    expect(page.locator("#journey-cancel")).to_be_hidden()
    truth = page.evaluate("() => window.brickpose.telemetry.truth")
    # A pixel of the map is some millimetres.
    assert math.dist((truth["x"], truth["y"]), GOAL) < 0.008
    assert abs(truth["theta"] - math.pi / 2) < 0.05


def choose(page, name):
    page.locator("#planning").get_by_role("button", name=name, exact=True).click()


def test_several_goals_are_pressed_and_driven_to(page, server):
    page.get_by_role("button", name="go to", exact=True).first.click()
    choose(page, "several")
    for place in ((0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1)):
        drag(page, place, place)
    choose(page, "take back")
    choose(page, "drive to 2 goals")
    expect(page.locator("#journey-text")).to_contain_text("goal 1 of 2")
    expect(page.locator("#journey-text")).to_contain_text("goal 2 of 2")
    expect(page.locator("#journey-text")).to_have_text(ARRIVED)
    truth = page.evaluate("() => window.brickpose.telemetry.truth")
    assert math.dist((truth["x"], truth["y"]), (-0.1, 0.1)) < 0.008


def test_a_zone_is_drawn_refuses_goals_shows_its_costs_and_is_removed(page, server):
    page.get_by_role("button", name="go to", exact=True).first.click()
    choose(page, "keep out")
    drag(page, (0.2, 0.2), (0.35, 0.35))
    expect(page.locator("#planning")).to_contain_text("remove the zone")
    with server.live() as socket:
        told = until(socket, lambda now: now["walls"] > 0)
    assert told["mode"] == "idle"
    choose(page, "costs")
    expect(page.locator("#planning + p")).to_contain_text("inflation_radius")
    drag(page, (0.27, 0.27), (0.27, 0.27))
    expect(page.locator("#toasts")).to_contain_text("keep-out zone")
    page.get_by_role("button", name="go to", exact=True).first.click()
    choose(page, "remove the zone")
    expect(page.locator("#planning")).not_to_contain_text("remove the zone")


def test_a_goal_ends_the_figure_eight_of_this_page_and_cancel_ends_the_journey(page, server):
    page.locator("#figure-eight").click()
    page.wait_for_function("window.brickpose.telemetry.mode === 'figure_eight'")
    page.get_by_role("button", name="type a pose").click()
    for name, value in (("pose-x", "-300"), ("pose-y", "-250"), ("pose-heading", "0")):
        page.locator(f"#{name}").fill(value)
    page.locator("#numbers-goal").click()
    expect(page.locator("#journey-text")).to_contain_text("left")
    # A renewal of the figure-eight would have ended it within a tenth of a second.
    begun = page.evaluate("window.brickpose.telemetry.stamp")
    page.wait_for_function("(begun) => window.brickpose.telemetry.stamp > begun + 0.5", arg=begun)
    expect(page.locator("#journey-text")).to_contain_text("left")
    expect(page.locator("#figure-eight")).to_have_attribute("aria-pressed", "false")
    page.locator("#journey-cancel").click()
    expect(page.locator("#journey-text")).to_contain_text("canceled; somebody canceled it")
    with server.live() as socket:
        until(socket, lambda now: now["mode"] == "idle")


@pytest.mark.real_time
def test_it_follows_the_tape_ahead_until_it_is_canceled(page, server):
    page.get_by_role("button", name="go to", exact=True).first.click()
    choose(page, "follow tape")
    # The tape's middle is a square of one metre; on it, the robot goes along it.
    page.wait_for_function("""() => {
        const { truth, navigation } = window.brickpose.telemetry;
        const [away, along] = [Math.abs(truth.x), Math.abs(truth.y)].sort((a, b) => b - a);
        return navigation?.state === "driving" && Math.abs(away - 0.5) < 0.04 && along < 0.45;
    }""")
    page.locator("#journey-cancel").click()
    expect(page.locator("#journey-text")).to_contain_text("canceled; somebody canceled it")
    with server.live() as socket:
        until(socket, lambda now: now["mode"] == "idle")


def test_a_goal_on_tape_is_refused_and_the_page_says_why(page, server):
    page.get_by_role("button", name="go to", exact=True).first.click()
    drag(page, (0.5, 0.0), (0.6, 0.0))
    expect(page.locator("#toasts")).to_contain_text("on a wall")


@pytest.mark.parametrize(("x", "words"), [("9000", "beyond the field"), ("500", "on a wall")])
def test_a_typed_goal_that_is_none_is_refused_and_the_page_says_why(page, server, x, words):
    page.get_by_role("button", name="type a pose").click()
    for name, value in (("pose-x", x), ("pose-y", "0"), ("pose-heading", "0")):
        page.locator(f"#{name}").fill(value)
    page.locator("#numbers-goal").click()
    expect(page.locator("#toasts")).to_contain_text(words)


def test_while_the_filter_is_paused_the_page_says_so(page, server):
    with server.live() as socket:
        assert ask(socket, type="pause")["type"] == "ack"
        page.wait_for_function("window.brickpose.telemetry.filter.paused")
        page.get_by_role("button", name="go to", exact=True).first.click()
        drag(page, (0.1, 0.0), (0.1, 0.1))
        expect(page.locator("#toasts")).to_contain_text("filter is paused")
        assert ask(socket, type="resume")["type"] == "ack"
        until(socket, lambda now: now["mode"] == "idle")


def test_a_page_that_is_closed_stops_the_robot(browser, server):
    context = show_all(browser.new_context(viewport={"width": 1200, "height": 800}))
    page = context.new_page()
    page.goto(server.url)
    page.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")
    page.get_by_role("button", name="go to", exact=True).first.click()
    expect(page.locator("#planning")).to_be_visible()
    drag(page, (-0.3, -0.2), (-0.3, 0.0))
    expect(page.locator("#journey-text")).to_contain_text("left")
    context.close()
    with server.live() as socket:
        told = until(socket, lambda now: now["navigation"]["state"] == "canceled")
    assert told["mode"] == "idle"


def test_a_program_sends_its_goal_once(server):
    with server.live() as socket:
        goal = {"x": 0.0, "y": 0.0, "theta": 0.0}
        assert ask(socket, type="navigate", poses=[goal])["type"] == "ack"
        # A tick from before may still tell how the last journey ended.
        until(socket, lambda now: (now["navigation"] or {}).get("state") == "driving")
        until(socket, lambda now: (now["navigation"] or {}).get("state") == "arrived")
