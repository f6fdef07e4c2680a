"""A scene of a lecture: field, poses, filter and layout by one press, and by a link."""

from __future__ import annotations

import math
from contextlib import suppress

import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import ask, serving, until
from websockets.exceptions import ConnectionClosed

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "stub", "--seed", "3") as running:
        yield running


def test_a_scene_is_kept_shown_again_and_shared(browser, server) -> None:
    for page in opened(browser, server, width=1366, height=768, view=False):
        with server.live() as live:
            ask(live, type="set_parameters", values={"filter": "particles", "sigma_hit": 0.02})
            ask(live, type="place", x=0.2, y=-0.1, theta=1.0)
            ask(live, type="scatter")
            until(
                live,
                lambda now: math.dist((now["truth"]["x"], now["truth"]["y"]), (0.2, -0.1)) < 0.01,
            )
        page.locator("#layout-open").click()
        page.locator("[data-layout=present]").click()
        page.locator("#scene-title").fill("kidnapped")
        page.locator("#scene-keep").click()
        scene = page.locator("#scenes li", has_text="kidnapped")
        link = scene.locator("a").get_attribute("href")
        assert link is not None
        page.locator("[data-layout=drive]").click()
        page.keyboard.press("Escape")
        # The server ends for another field, and may take the answer with it.
        with server.live() as live, suppress(ConnectionClosed):
            ask(live, type="use_field", name="square")
        page.wait_for_function("window.brickpose.telemetry.map === 'square'")
        scene.get_by_role("button", name="kidnapped", exact=True).click()
        page.wait_for_function("window.brickpose.telemetry.map === 'stub'")
        page.wait_for_function("Math.abs(window.brickpose.telemetry.truth.x - 0.2) < 0.01")
        page.wait_for_function("window.brickpose.telemetry.filter.kind === 'particles'")
        expect(page.locator("#drive")).to_be_hidden()
        expect(page.locator("#stage-bar")).to_be_visible()
        # Numbers of several fields are not taken for a difference of parameters.
        page.locator("#runs-open").click()
        expect(page.locator("#runs-body tr").first).to_contain_text("now, on stub")
        expect(page.locator("#runs-body")).to_contain_text("before, on square")
        page.keyboard.press("Escape")
        page.reload()
        expect(scene).to_be_visible()
        scene.get_by_role("button", name="Forget kidnapped").click()
        expect(page.locator("#scenes")).to_be_hidden()
        # By a link, in a browser that asks before it moves the robot.
        with server.live() as live:
            ask(live, type="reset")
            ask(live, type="place", x=0.0, y=0.0, theta=0.0)
        page.evaluate("window.confirm = (words) => { window.asked = words; return true; }")
        page.evaluate(f"location.hash = {link!r}")
        page.wait_for_function("Math.abs(window.brickpose.telemetry.truth.x - 0.2) < 0.01")
        words = "Show the scene kidnapped? It sets robot, filter and layout."
        assert page.evaluate("window.asked") == words
        page.evaluate("location.hash = '#scene=%7B%7D'")
        expect(page.locator("#toasts")).to_contain_text("This link has no scene.")


def test_a_scene_keeps_how_sure_the_filter_is(browser, server) -> None:
    """Told with the spread of the program's start, a robot that was found would be lost again."""
    for page in opened(browser, server, width=1366, height=768, view=False):
        with server.live() as live:
            ask(live, type="reset")
            ask(live, type="place", x=0.1, y=0.1, theta=0.5)
            ask(live, type="set_pose", x=0.1, y=0.1, theta=0.5, sd_xy=0.003, sd_theta=0.02)
        sure = """() => {
            const { estimate } = window.brickpose.telemetry;
            return estimate && Math.abs(estimate.x - 0.1) < 0.02 && estimate.covariance[0] < 1e-4;
        }"""
        page.wait_for_function(sure)
        page.locator("#layout-open").click()
        page.locator("#scene-title").fill("found")
        page.locator("#scene-keep").click()
        page.keyboard.press("Escape")
        page.get_by_role("button", name="scatter", exact=True).first.click()
        page.wait_for_function(f"!({sure})()")
        page.locator("#scenes").get_by_role("button", name="found", exact=True).click()
        page.wait_for_function(sure)


def test_a_projector_has_large_buttons_and_letters(browser, server) -> None:
    for page in opened(browser, server, width=1920, height=1080, view=False):
        page.locator("#layout-open").click()
        page.locator("[data-layout=present]").click()
        page.locator("#large-text").click()
        page.keyboard.press("Escape")
        smallest = page.evaluate(
            """() => Math.min(...[...document.querySelectorAll("body *")]
                .filter((one) => one.checkVisibility()
                  && !one.closest(".hidden-text, .skip, .handles")
                  && [...one.childNodes].some((part) => part.nodeType === 3 && part.data.trim()))
                .map((one) => parseFloat(getComputedStyle(one).fontSize)))"""
        )
        assert smallest >= 28
        bar = page.locator("#stage-bar")
        page.locator("[data-more-of=bar]").click()
        # All tools in one row, a plot that is one, and no need to scroll for the large buttons.
        high = "(one) => one.getBoundingClientRect().height"
        assert page.locator(".bar").evaluate(high) < 3.5 * smallest
        assert page.locator("#plots-canvas").evaluate(high) > 220
        assert page.evaluate("document.documentElement.scrollHeight") == 1080
        with server.live() as live:
            bar.get_by_role("button", name="Back to start").click()
            bar.get_by_role("button", name="Figure-eight").click()
            until(live, lambda now: now["mode"] == "figure_eight")
            expect(bar.get_by_role("button", name="Figure-eight")).to_have_attribute(
                "aria-pressed", "true"
            )
            bar.get_by_role("button", name="scatter").click()
            until(live, lambda now: now["integrity"]["state"] != "certain")
            page.locator("#stop").click()
            until(live, lambda now: now["mode"] == "idle")
