"""The wall's page by itself: what its fields send."""

from __future__ import annotations

import math

import pytest
from playwright.sync_api import Page, Route, expect

from app.settings.config import FRONTEND

pytestmark = pytest.mark.browser
PLACE = "http://wall.test/"


@pytest.fixture
def page(browser):
    """The page from its files; nobody answers what it asks."""

    def answer(route: Route) -> None:
        path = route.request.url.removeprefix(PLACE).partition("?")[0]
        if path.startswith("static/"):
            route.fulfill(path=FRONTEND / path.removeprefix("static/"))
        elif path:
            route.fulfill(status=404, json={})
        else:
            route.fulfill(path=FRONTEND / "features" / "classroom" / "wall" / "wall.html")

    with browser.new_context() as context:
        made = context.new_page()
        made.route("**/*", answer)
        made.goto(PLACE)
        yield made


def sent(page: Page):
    with page.expect_request("**/api/place") as request:
        page.locator("#place button").click()
    return request.value.post_data_json


def test_places_are_sent_as_they_were_typed_with_points_or_commas(page):
    expect(page.locator("#place-x")).to_have_value("0.2")
    assert sent(page) == {"x": 0.2, "y": 0, "theta": 0}
    page.locator("#place-x").fill("0,05")
    page.locator("#place-y").fill("-0,3")
    page.locator("#place-theta").fill("90.0")
    assert sent(page) == {"x": 0.05, "y": -0.3, "theta": pytest.approx(math.pi / 2)}


@pytest.mark.parametrize("typed", ["0,0,5", "here", "1000"])
def test_what_is_no_number_or_too_far_is_not_sent(page, typed):
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.locator("#place-x").fill(typed)
    page.locator("#place button").click()
    expect(page.locator("#place-x:invalid")).to_have_count(1)
    assert f"{PLACE}api/place" not in asked


def test_who_works_in_jupyterlab_is_said_to_and_gets_no_orders(page):
    tile = {"login": "ada", "name": "Ada", "pending": False, "awake": True, "notebook": True,
            "url": "/user/ada/brickpose/"}  # fmt: skip
    led = {"login": "bo", "name": "Bo", "pending": False, "awake": True, "frozen": True}
    tiles = [tile]
    page.route("**/api/tiles", lambda route: route.fulfill(json=tiles))
    first = page.locator("article[data-login=ada]")
    expect(first).to_contain_text("in JupyterLab, whose robot takes no orders from here")
    expect(first.locator("a")).to_have_attribute("href", "/user/ada/brickpose/")
    expect(page.locator("#summary")).to_have_text("1 of 1 are here")
    for order in ("#freeze", "#say", "#place", "#lesson", "#field", "#recording", "#recordings"):
        expect(page.locator(order)).to_be_hidden()
    for stays in ("#start", "#collect"):
        expect(page.locator(stays)).to_be_visible()
    tiles.append(led)
    expect(page.locator("#say")).to_be_visible()
    expect(page.locator("#freeze")).to_have_text("Let all go on")
