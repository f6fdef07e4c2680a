"""What a first visit shows: little, with the rest one click away and remembered."""

from __future__ import annotations

import pytest
from browsing import opened
from playwright.sync_api import Page, expect
from serving import serving, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]

MOST_CONTROLS, MOST_WORDS = 30, 120
COUNT = """() => {
  const seen = (element) => {
    const box = element.getBoundingClientRect();
    return element.checkVisibility({ visibilityProperty: true, opacityProperty: true })
      && box.width > 2 && box.height > 2 && !element.closest(".hidden-text, .skip");
  };
  const controls = [...document.querySelectorAll(
    "button, a[href], input, select, textarea, [tabindex='0']")].filter(seen);
  const words = [];
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const { parentElement: parent, data } = texts.currentNode;
    if (data.trim() && !parent.closest("script, noscript, datalist, option") && seen(parent))
      words.push(...data.trim().split(/\\s+/));
  }
  return [controls.map((one) => one.id || one.outerHTML.slice(0, 60)), words];
}"""


@pytest.fixture(scope="module")
def server():
    with serving("--map", "stub", "--seed", "3") as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1366, height=768, view=False, first_visit=True)


def test_it_is_counted_how_much_there_is_to_see(page: Page) -> None:
    page.wait_for_function("document.querySelector('#camera-hint').textContent")
    controls, words = page.evaluate(COUNT)
    assert len(controls) <= MOST_CONTROLS, controls
    assert len(words) <= MOST_WORDS, words
    assert len(controls) > 20, "it counts what is there"


def test_what_is_done_first_needs_no_more_clicks_than_ever(page: Page) -> None:
    for name in ("figure-eight", "home", "scatter", "calibration-open", "mapping-open", "record"):
        expect(page.locator(f"#{name}")).to_be_visible()
    for tool in ("place", "ask"):
        expect(page.locator(f"[data-tool={tool}]")).to_be_visible()
    expect(page.locator("#parameters")).to_be_hidden()
    page.get_by_role("button", name="Filter", exact=True).click()
    for part in ("[name=sigma_hit] >> nth=0", "#by-hand", "#again", "#runs-open"):
        expect(page.locator(part)).to_be_visible()
    page.get_by_role("button", name="Filter", exact=True).click()
    expect(page.locator("#parameters")).to_be_hidden()


def test_what_was_asked_for_stays_after_a_reload(page: Page) -> None:
    tool = page.locator("[data-tool=measure]")
    expect(tool).to_be_hidden()
    page.locator("[data-more-of=map]").click()
    page.get_by_role("button", name="3D", exact=True).click()
    expect(tool).to_be_visible()
    page.reload()
    expect(tool).to_be_visible()
    expect(page.locator("#view")).to_be_visible()
    expect(page.locator("#stats")).to_be_hidden()
    page.locator("[data-more-of=map]").click()
    expect(tool).to_be_hidden()


def test_two_values_are_compared_by_four_clicks(page: Page, server) -> None:
    clicks = 0

    def click(selector: str) -> None:
        nonlocal clicks
        page.locator(selector).first.click()
        clicks += 1

    with server.live() as live:
        click("#figure-eight")
        begun = until(live, lambda now: now["mode"] == "figure_eight")["stamp"]
        until(live, lambda now: now["stamp"] > begun + 12)
        click("[data-panels~=filter]")
        click("input[name=sigma_hit][type=text]")
        page.keyboard.press("Control+a")
        page.keyboard.type("30")
        page.keyboard.press("Enter")
        changed = until(live, lambda now: now["mode"] == "figure_eight")["stamp"]
        until(live, lambda now: now["stamp"] > changed + 12)
        click("#runs-open")
    rows = page.locator("#runs-body tr")
    expect(rows.first).to_contain_text("sigma_hit 30 instead of 3 mm")
    expect(rows.nth(1)).to_contain_text("parameters as at the start")
    expect(rows.nth(1)).to_contain_text("to", timeout=20_000)
    assert clicks <= 4
    for row in (0, 1):
        assert float(rows.nth(row).locator("td").first.inner_text().split()[0]) > 0
    page.keyboard.press("Escape")
    expect(page.locator("#runs")).to_be_hidden()
    page.locator("#stop").click()


def test_escape_and_a_press_beside_close_every_box_wherever_the_focus_is(page: Page) -> None:
    page.locator("[data-more-of=bar]").click()
    page.get_by_role("button", name="Filter", exact=True).click()
    boxes = page.evaluate("[...document.querySelectorAll('.popover')].map((box) => box.id)")
    assert len(boxes) >= 7
    for box in boxes:
        opener = page.locator(f"button[aria-controls={box}]:visible").first
        for way in ("escape", "beside"):
            opener.click()
            expect(page.locator(f"#{box}")).to_be_visible()
            if way == "escape":
                page.evaluate("document.activeElement.blur()")
                page.keyboard.press("Escape")
            else:
                page.locator(".bar h1").click()
            expect(page.locator(f"#{box}")).to_be_hidden()
