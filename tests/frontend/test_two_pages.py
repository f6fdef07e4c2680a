"""Two people at one robot, each with a page: who drives, who stops, who only watches."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from browsing import keep_what_is_told, let_go
from playwright.sync_api import Page, expect
from serving import ServedProgram, ask, until
from serving import server as started
from websockets.sync.client import connect

from benchmarks.programs import START_S, estimated

pytestmark = [pytest.mark.browser, pytest.mark.slow]

SIZE = {"width": 1100, "height": 760}


@pytest.fixture(scope="module")
def server() -> Iterator[ServedProgram]:
    arguments = ["--token", "drive-me", "--watch-token", "watch-me"]
    with started("--robot", "kinematic", "--map", "stub", *arguments) as running:
        wait(running, estimated)
        yield running


def wait(server, condition) -> dict:
    """Telemetry, from now on, of which a condition holds."""
    header = {"Authorization": "Bearer watch-me"}
    address = f"{server.url.replace('http', 'ws')}/api/live"
    with connect(address, additional_headers=header, max_queue=None) as socket:
        return until(socket, condition, START_S)


def back_to_start(server) -> None:
    """A key is held longer on a busy machine: then a figure-eight would not fit where it ends."""
    header = {"Authorization": "Bearer drive-me"}
    address = f"{server.url.replace('http', 'ws')}/api/live"
    with connect(address, additional_headers=header, max_queue=None) as socket:
        assert ask(socket, type="reset")["type"] == "ack"


@contextmanager
def person(browser, server, token: str) -> Iterator[Page]:
    """A page in a browser of its own, with its own cookies."""
    with keep_what_is_told(browser.new_context(viewport=SIZE)) as context:
        page = context.new_page()
        page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
        page.goto(f"{server.url}/?token={token}")
        expect(page.locator("#robot-state")).not_to_have_text("connecting")
        yield page


def test_a_stop_of_one_holds_against_the_key_that_another_holds(browser, server) -> None:
    with person(browser, server, "drive-me") as ann, person(browser, server, "drive-me") as bob:
        assert "token" not in ann.url
        ann.keyboard.down("w")
        wait(server, lambda now: now["twist"]["v"] > 0.1)
        expect(bob.locator("#drive-who")).to_contain_text("drives")
        bob.keyboard.press(" ")
        still = wait(server, lambda now: now["twist"]["v"] == 0)
        wait(server, lambda now: now["twist"]["v"] != 0 or now["stamp"] > still["stamp"] + 1.5)
        ann.keyboard.up("w")
        assert wait(server, lambda now: True)["twist"]["v"] == 0
        ann.keyboard.down("w")
        wait(server, lambda now: now["twist"]["v"] > 0.1)
        ann.keyboard.up("w")
        let_go(ann)
        wait(server, lambda now: now["mode"] == "idle")


def test_a_figure_eight_that_somebody_stopped_does_not_go_on_by_itself(browser, server) -> None:
    back_to_start(server)
    with person(browser, server, "drive-me") as ann, person(browser, server, "drive-me") as bob:
        ann_eight, bob_eight = (
            page.get_by_role("button", name="Figure-eight") for page in (ann, bob)
        )
        ann_eight.click()
        wait(server, lambda now: now["mode"] == "figure_eight")
        expect(bob.locator("#drive-who")).to_contain_text("drives")
        bob_eight.click()
        expect(bob.locator("#toasts")).to_contain_text("take over to drive yourself")
        bob.keyboard.press(" ")
        expect(ann_eight).to_have_attribute("aria-pressed", "false")
        wait(server, lambda now: now["mode"] == "idle")


def test_pages_of_one_browser_are_one_person_who_is_named(browser, server) -> None:
    back_to_start(server)
    with person(browser, server, "drive-me") as ann, person(browser, server, "drive-me") as bob:
        ann.locator("#layout-open").click()
        ann.locator("#person-name").fill("Ann")
        ann.locator("#person-name").press("Enter")
        ann.wait_for_function("window.brickpose.connected")
        hers = ann.context.new_page()
        hers.goto(server.url)
        hers.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry")
        ann.locator("#figure-eight").click()
        wait(server, lambda now: now["mode"] == "figure_eight")
        expect(bob.locator("#drive-who")).to_have_text("the computer of Ann drives")
        expect(hers.locator("#robot-state")).to_have_text("figure-eight")
        expect(hers.locator("#drive-who")).to_be_empty()
        hers.keyboard.down("s")
        wait(server, lambda now: now["twist"]["v"] < -0.05)
        # She went on from her other page: this one lets go, and says nothing.
        expect(ann.locator("#figure-eight")).to_have_attribute("aria-pressed", "false")
        hers.keyboard.up("s")
        let_go(hers)
        wait(server, lambda now: now["mode"] == "idle")
        assert ann.locator("#toasts .toast").count() == 0


def test_the_drive_can_be_taken(browser, server) -> None:
    back_to_start(server)
    with person(browser, server, "drive-me") as ann, person(browser, server, "drive-me") as bob:
        ann.get_by_role("button", name="Figure-eight").click()
        first = wait(server, lambda now: now["mode"] == "figure_eight")["driver"]["name"]
        bob.get_by_role("button", name="take over").click()
        wait(server, lambda now: now["mode"] == "idle" and now["driver"]["name"] != first)
        expect(ann.get_by_role("button", name="Figure-eight")).to_have_attribute(
            "aria-pressed", "false"
        )
        bob.keyboard.down("s")
        wait(server, lambda now: now["twist"]["v"] < -0.05)
        bob.keyboard.up("s")
        let_go(bob)
        wait(server, lambda now: now["mode"] == "idle")


def test_who_only_watches_is_told_so_and_does_not_drive(browser, server) -> None:
    with person(browser, server, "watch-me") as eve:
        expect(eve.locator("#drive-who")).to_have_text("this link only watches")
        eve.keyboard.down("w")
        begun = wait(server, lambda now: True)["stamp"]
        now = wait(server, lambda now: now["twist"]["v"] != 0 or now["stamp"] > begun + 0.7)
        eve.keyboard.up("w")
        assert now["twist"]["v"] == 0


def test_without_a_token_a_form_asks_for_it(browser, server) -> None:
    with browser.new_context(viewport=SIZE) as context:
        page = context.new_page()
        page.goto(server.url)
        page.get_by_label("Token").fill("watch-me")
        page.get_by_role("button", name="Open").click()
        expect(page.locator("#drive-who")).to_have_text("this link only watches")
        assert page.evaluate("document.cookie") == ""
