"""Help on the page: the sheet of keys, the tour of the first visit, tips by touch."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial

import pytest
from axe import needs_axe, violations
from browsing import LOOKS, PATIENCE_MS, opened
from playwright.sync_api import Browser, Page, expect
from serving import serving

pytestmark = [pytest.mark.browser, pytest.mark.slow]
A_PERSON = "Object.defineProperty(navigator, 'webdriver', { get: () => false })"
STEPS = ["Where the robot is", "Drive", "What it sees", "Let it get lost",
         "Change how it thinks", "When in doubt"]  # fmt: skip


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture(scope="module")
def shared(browser, server):
    yield from opened(browser, server, width=1280, height=720, view=False, reduced_motion="reduce")


@pytest.fixture
def page(shared: Page) -> Iterator[Page]:
    yield shared
    shared.keyboard.press("Escape")
    expect(shared.locator("#help, #tour")).to_have_count(0)


def phone(browser: Browser, server, **options) -> Iterator[Page]:
    yield from opened(
        browser,
        server,
        width=390,
        height=844,
        view=False,
        has_touch=True,
        is_mobile=True,
        **options,
    )


def test_the_question_mark_opens_the_help_and_escape_gives_the_focus_back(page):
    page.locator("#record").focus()
    page.keyboard.press("?")
    sheet = page.get_by_role("dialog", name="Help")
    expect(sheet).to_contain_text("drive; the arrow keys do, too")
    assert page.evaluate("document.activeElement.id") == "help-title"
    page.keyboard.press("Escape")
    expect(sheet).to_have_count(0)
    assert page.evaluate("document.activeElement.id") == "record"


def test_what_is_seldom_asked_for_is_loaded_then(browser, server):
    for page in opened(browser, server, width=1280, height=720, view=False):
        page.wait_for_function("window.brickpose.delays.length > 0")
        # The floor's picture is asked for last.
        page.wait_for_function(
            "performance.getEntriesByType('resource').some((one) => /field.png/.test(one.name))"
        )
        loaded = page.evaluate(
            "performance.getEntriesByType('resource')"
            ".concat(performance.getEntriesByType('navigation'))"
            ".filter((one) => !one.name.includes('/view/'))"
            ".map((one) => [new URL(one.name).pathname, one.encodedBodySize])"
        )
        # What the page asks for again and again counts once.
        assert sum(dict(loaded).values()) <= 200_000
        late = ("sheet.js", "tour.js", "tips.js", "help.css", "saving.js")
        assert not [path for path, _ in loaded if path.endswith(late)]


def test_a_question_mark_that_is_typed_is_text(page):
    page.locator("#field-open").click()
    page.locator("#field-name").press("?")
    expect(page.locator("#field-name")).to_have_value(re.compile(r"\?"))
    expect(page.locator("#help")).to_have_count(0)
    page.keyboard.press("Escape")


def test_the_help_explains_all_that_the_map_draws_and_leaves_stop_in_reach(page):
    page.locator("#help-open").click()
    meanings = page.locator("#help .meanings li")
    for entry in page.locator("#map .legend li:not([hidden])").all():
        words = meanings.filter(has_text=entry.inner_text())
        expect(words.first).to_contain_text(entry.get_attribute("title"))
    page.locator("#stop").click()
    # Arrow keys scroll the help; they drive nothing.
    page.locator("#help-title").focus()
    page.keyboard.press("ArrowDown")
    assert page.evaluate("window.brickpose.telemetry.mode") == "idle"


def test_the_documents_open_beside_the_page(page):
    page.locator("#help-open").click()
    links = page.locator("#help a").evaluate_all("all => all.map((one) => one.href)")
    for link in links:
        assert page.request.get(link).status == 200
    with page.context.expect_page() as beside:
        page.get_by_role("link", name="Words, each for one thing").click()
    expect(beside.value.get_by_role("heading", name="Glossary")).to_be_visible()
    beside.value.close()


def test_the_tour_shows_each_part_by_keys_alone(page):
    page.locator("#help-open").press("Enter")
    page.get_by_role("button", name="Show me round").press("Enter")
    tour = page.get_by_role("dialog", name=STEPS[0])
    for title in STEPS:
        tour = page.get_by_role("dialog", name=title)
        expect(tour).to_be_in_viewport(ratio=1)
        expect(page.locator("[data-toured]")).to_be_visible()
        assert page.evaluate("document.activeElement.id") == "tour-title"
        page.locator("#stop").click(trial=True)
        tour.locator(".primary").press("Enter")
    expect(page.locator("[data-toured]")).to_have_count(0)


def test_who_comes_first_is_shown_round_and_never_again(browser, server):
    context = browser.new_context(viewport={"width": 1280, "height": 720}, locale="de-DE")
    context.set_default_timeout(PATIENCE_MS)
    context.add_init_script(A_PERSON)
    page = context.new_page()
    page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
    page.goto(server.url)
    expect(page.get_by_role("dialog", name="Wo der Roboter ist")).to_be_visible()
    page.reload()
    expect(page.get_by_role("dialog", name="Wo der Roboter ist")).to_be_visible()
    page.get_by_role("button", name="Rundgang beenden").click()
    page.reload()
    page.wait_for_function("window.brickpose?.connected")
    expect(page.locator("#tour")).to_have_count(0)
    page.goto(f"{server.url}/?tour")
    expect(page.locator("#tour")).to_be_visible()
    context.close()


def test_on_a_phone_the_tour_turns_to_each_panel(browser, server):
    for page in phone(browser, server):
        page.goto(f"{server.url}/?tour")
        tabs = []
        for title in STEPS:
            expect(page.get_by_role("dialog", name=title)).to_be_in_viewport(ratio=1)
            tabs.append(page.evaluate("document.body.dataset.tab"))
            page.locator("#tour .primary").tap()
        assert tabs == ["map", "map", "camera", "map", "filter", "filter"]


def test_a_finger_that_stays_is_told_what_a_button_does_and_presses_nothing(browser, server):
    for page in phone(browser, server):
        tip = page.locator(".tip")
        # The tips are loaded first, which takes longer on a busy machine.
        hold(page, "#scatter", tip.wait_for)
        expect(tip).to_have_text("The robot may be anywhere: spread the cloud over the field")
        expect(tip).to_be_in_viewport(ratio=1)
        expect(page.locator("#undo")).to_be_disabled()
        # A short touch presses, and takes the tip away.
        page.locator("#scatter").tap()
        expect(tip).to_have_count(0)
        expect(page.locator("#undo")).to_be_enabled()
        page.locator("#undo").tap()
        hold(page, "#stop", partial(page.wait_for_timeout, 1000))
        expect(tip).to_have_count(0)


def hold(page: Page, selector: str, wait: Callable[[], None]) -> None:
    """Touch an element until something was waited for."""
    box = page.locator(selector).bounding_box()
    assert box is not None
    touch = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    session = page.context.new_cdp_session(page)
    session.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [touch]})
    wait()
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    session.detach()


@needs_axe
@pytest.mark.parametrize("look", LOOKS)
def test_axe_finds_nothing_in_help_tour_and_documents(page, server, look):
    page.emulate_media(**LOOKS[look])
    page.locator("#help-open").click()
    expect(page.locator("#help")).to_be_visible()
    found = violations(page, "#help")
    page.get_by_role("button", name="Show me round").click()
    expect(page.locator("#tour")).to_be_visible()
    found += violations(page, "#tour")
    page.keyboard.press("Escape")
    beside = page.context.new_page()
    beside.emulate_media(**LOOKS[look])
    for name in ("page.md", "evaluation.md"):
        for width in (1280, 390):
            beside.set_viewport_size({"width": width, "height": 800})
            beside.goto(f"{server.url}/help/{name}")
            found += violations(beside)
            assert beside.evaluate("document.documentElement.scrollWidth <= innerWidth")
    beside.close()
    page.emulate_media(color_scheme="null", forced_colors="null")
    assert not found, "\n".join(found)
