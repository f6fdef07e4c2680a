"""On the page: a particle is asked, a ghost is dragged, and the filter goes by hand and back."""

from __future__ import annotations

import re

import pytest
from browsing import opened
from playwright.sync_api import Page, expect
from serving import ask, serving, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture(scope="module")
def page(browser, server):
    with server.live() as live:
        ask(live, type="set_parameters", values={"filter": "particles"})
        until(live, lambda now: now["filter"]["kind"] == "particles" and now["estimate"])
    yield from opened(browser, server, width=1280, height=800, view=False)


def estimate(page: Page) -> dict:
    return page.evaluate("window.brickpose.telemetry.estimate")


def pixel(page: Page, x: float, y: float) -> list[float]:
    """Where a place is on the screen, once what has opened beside the map is drawn."""
    frames = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    page.evaluate(frames)
    return page.evaluate("([x, y]) => window.brickpose.mapPixel(x, y)", [x, y])


def number(text: str) -> float:
    return float(text.replace("−", "-"))


def weight(page: Page) -> str:
    return page.locator("#particles .fit tr").nth(2).inner_text()


def test_a_particle_is_asked_by_two_clicks_and_a_ghost_is_dragged(page: Page) -> None:
    page.locator("button[data-tool=ask]").click()
    box = page.locator("#particles")
    expect(box).to_be_visible()
    place = estimate(page)
    page.mouse.click(*pixel(page, place["x"] + 0.01, place["y"]))
    expect(box.get_by_role("status").first).to_contain_text("A particle: it weighs")
    expect(box.get_by_role("row").nth(1)).to_contain_text("log-likelihood")
    # A ray in the middle of the fan says what it expects.
    chart = box.get_by_role("application")
    chart.focus()
    for _ in range(40):
        chart.press("ArrowRight")
    expect(box.locator(".readout")).to_contain_text(
        re.compile(r"Ray at −?\d+°: expected .*, measured .*\. Its share is")
    )
    before = weight(page)
    x, y = (number(box.get_by_role("textbox").nth(i).input_value()) / 1000 for i in (0, 1))
    at = pixel(page, x, y)
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] + 10, at[1])
    page.mouse.move(at[0] + 25, at[1])
    page.mouse.up()
    expect(box.get_by_role("status").first).to_contain_text("no particle")
    expect(box.locator(".fit tr").nth(2)).not_to_have_text(before)
    # The same in numbers, in German notation too; what is no number is said.
    box.get_by_role("textbox").nth(0).fill("12,5")
    box.get_by_role("textbox").nth(0).press("Enter")
    expect(box.locator(".fit tr").nth(3)).to_contain_text(re.compile(r"1[23], "))
    box.get_by_role("textbox").nth(0).fill("far")
    box.get_by_role("textbox").nth(0).press("Enter")
    expect(box.get_by_role("status").first).to_have_text("That is not a number.")
    page.locator("#map-canvas").press("Escape")
    expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
    box.get_by_role("button", name="Close what particles say").click()
    expect(box).to_be_hidden()


def test_the_field_is_shaded_by_the_likelihood_of_the_scan(page: Page) -> None:
    page.locator("button[data-tool=ask]").click()
    box = page.locator("#particles")
    expect(box).to_be_visible()
    place = estimate(page)
    page.mouse.click(*pixel(page, place["x"], place["y"]))
    expect(box.get_by_role("status").first).to_contain_text("A particle: it weighs")
    box.get_by_role("button", name="show").click()
    said = box.locator(".landscape").get_by_role("status")
    expect(said).to_contain_text(re.compile(r"fits best\. likelihood_field, cells of \d+ mm"))
    expect(said).to_contain_text("At the pose asked, the heading")
    marks = box.locator(".scale li")
    assert [mark.inner_text().strip() for mark in marks.all()] == ["1", "10⁻²", "10⁻⁴", "10⁻⁶"]
    box.get_by_role("button", name="show").click()
    expect(said).to_contain_text("How well the newest scan fits")
    box.get_by_role("button", name="Close what particles say").click()


def test_the_filter_goes_by_hand_and_back(page: Page, server) -> None:
    page.locator("#by-hand").click()
    box = page.locator("#particles .hand")
    box.get_by_role("button", name="by hand").click()
    expect(box.get_by_role("status")).to_contain_text("Begin with predict")
    expect(box.get_by_role("button", name="weigh")).to_be_disabled()
    with server.live() as live:
        ask(live, type="drive", v=0.1, omega=0.3)
        until(live, lambda now: now["filter"]["hand"]["ahead"]["x"] > 0.01)
        until(live, lambda now: now["mode"] == "idle" and now["twist"] == {"v": 0, "omega": 0})
        waited = until(live, lambda now: now["filter"]["hand"]["last"] is None)
    said = {}
    for step, words in (
        ("predict", "The noise drawn: ±"),
        ("weigh", "are effective; it was"),
        ("resample", "died (crosses)"),
    ):
        box.get_by_role("button", name=step).click()
        expect(box.get_by_role("status")).to_contain_text(words)
        said[step] = box.get_by_role("status").inner_text()
    page.wait_for_function(
        f"window.brickpose.telemetry.filter.updates === {waited['filter']['updates'] + 1}"
    )
    # Back, and the same again: the same numbers are drawn.
    for step in ("weigh", "predict"):
        box.get_by_role("button", name="back").click()
        expect(box.get_by_role("status")).to_have_text(said[step])
    for step in ("weigh", "resample"):
        box.get_by_role("button", name=step).click()
        expect(box.get_by_role("status")).to_have_text(said[step])
    box.get_by_role("button", name="by hand").click()
    expect(box.get_by_role("status")).to_contain_text("one at a time")
    page.wait_for_function("window.brickpose.telemetry.filter.hand === null")


def test_by_hand_takes_the_particle_filter_in_place_of_another(page: Page, server) -> None:
    with server.live() as live:
        ask(live, type="set_parameters", values={"filter": "kalman"})
        until(live, lambda now: now["filter"]["kind"] == "kalman")
        refused = ask(live, type="filter_step", step="predict")
        assert "the filter kalman has no steps by hand; choose particles" in refused["message"]
    box = page.locator("#particles .hand")
    expect(box.get_by_role("status")).to_contain_text(
        "Takes the particle filter in place of kalman"
    )
    box.get_by_role("button", name="by hand").click()
    expect(box.get_by_role("button", name="predict")).to_be_enabled()
    box.get_by_role("button", name="by hand").click()
    page.wait_for_function("window.brickpose.telemetry.filter.hand === null")
