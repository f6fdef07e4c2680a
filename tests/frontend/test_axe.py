"""No page breaks a rule of axe, in any theme and size, with menus open and lists scrolled."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from axe import LOOK_RULES, needs_axe, violations
from browsing import LOOKS, PATIENCE_MS, opened
from playwright.sync_api import Browser, Page, expect
from serving import serving, started

pytestmark = [pytest.mark.browser, needs_axe, pytest.mark.slow]

SIZES = {"laptop": (1280, 720), "phone": (390, 844)}
IS_COLOURED = "matchMedia('(prefers-color-scheme: dark), (forced-colors: active)').matches"
MENUS = ("layout", "field", "recordings", "calibration", "mapping")
BUTTONS = {
    "#problems": "#problems-list", "#plots-values": "#plots", "#numbers-toggle": "#map",
    "#camera-profile": "#camera",
}  # fmt: skip


@pytest.fixture(scope="module")
def server():
    with serving("--robot", "kinematic", "--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture(scope="module")
def shared(browser, server):
    """One page for all looks and sizes; colours change at once, not little by little."""
    yield from opened(browser, server, width=1280, height=720, view=False, reduced_motion="reduce")


@pytest.fixture(params=LOOKS)
def page(request, shared: Page) -> Iterator[Page]:
    shared.emulate_media(**LOOKS[request.param])
    yield shared
    shared.emulate_media(color_scheme="null", forced_colors="null")


def show(page: Page, size: str) -> None:
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})


def click(page: Page, selector: str) -> None:
    """Press a button wherever it is: some are elsewhere on a phone."""
    page.evaluate("(selector) => document.querySelector(selector).click()", selector)


def faults(page: Page, part: str = "html") -> list[str]:
    """By all rules in the light look, in others by those that ask for colours and sizes.

    A look changes nothing else, see ``test_a_look_changes_colours_and_borders_only``.
    """
    rules = LOOK_RULES if page.evaluate(IS_COLOURED) else ()
    return [f"{part}: {fault}" for fault in violations(page, part, rules)]


def faults_of_menus(page: Page) -> list[str]:
    found = []
    for name in MENUS:
        click(page, f"#{name}-open")
        expect(page.locator(f"#{name}")).to_be_visible()
        found += faults(page, f"#{name}")
        click(page, f"#{name}-close")
    return found


def faults_of_parameters(page: Page) -> list[str]:
    """With meanings and without, at several heights of the list."""
    found = []
    for share in (0, 0.3, 0.6, 1):
        page.evaluate(
            "(share) => { const list = document.querySelector('#parameters');"
            " list.scrollTop = share * list.scrollHeight; }",
            share,
        )
        found += faults(page, "#filter")
    click(page, "#explain")
    found += faults(page, "#filter")
    click(page, "#explain")
    return found


def test_the_dashboard_with_all_that_opens(page):
    show(page, "laptop")
    found = faults(page) + faults_of_menus(page) + faults_of_parameters(page)
    for button, part in BUTTONS.items():
        click(page, button)
        found += faults(page, part)
        click(page, button)
    assert not found, "\n".join(found)


def test_the_phone_with_each_tab_and_all_that_opens(page):
    show(page, "phone")
    found = []
    for tab in ("camera", "map", "view", "filter"):
        click(page, f"[data-name={tab}]")
        found += faults(page)
        if tab == "view":
            click(page, "[data-scene-tool=goal]")
            expect(page.locator("#view-say")).to_contain_text("where the robot shall go")
            found += faults(page, "#view")
            click(page, "[data-scene-tool=goal]")
    found += faults_of_parameters(page)
    click(page, "#more")
    found += faults(page, "header.bar") + faults_of_menus(page)
    click(page, "#more")
    assert not found, "\n".join(found)


def test_what_is_said_in_passing(page):
    show(page, "laptop")
    click(page, "[data-tool=measure]")
    click(page, "#numbers-toggle")
    page.locator("#pose-x").fill("99999")
    page.locator("#numbers-set").click()
    expect(page.locator("#toasts .toast")).to_have_count(1)
    found = faults(page, "#toasts") + faults(page, "#map")
    page.locator("#toasts button").click()
    page.locator("#pose-x").fill("0")
    click(page, "#numbers-toggle")
    click(page, "[data-tool=look]")
    assert not found, "\n".join(found)


@pytest.mark.parametrize("size", SIZES)
def test_what_particles_say(page, size):
    """A particle asked, the filter by hand, and the likelihood, all open."""
    show(page, size)
    click(page, "[data-name=map]")
    click(page, "#by-hand")
    box = page.locator("#particles")
    expect(box).to_be_visible()
    box.get_by_role("button", name="nearest to estimate").click()
    expect(box.get_by_role("status").first).to_contain_text("A particle: it weighs")
    box.get_by_role("button", name="show", exact=True).click()
    expect(box.locator(".scale li")).to_have_count(4)
    found = faults(page, "#map")
    box.get_by_role("button", name="by hand", exact=True).click()
    box.get_by_role("button", name="predict").click()
    expect(box.locator(".hand").get_by_role("status")).to_contain_text("The noise drawn")
    found += faults(page, "#map")
    box.get_by_role("button", name="by hand", exact=True).click()
    box.get_by_role("button", name="Close what particles say").click()
    assert not found, "\n".join(found)


@pytest.fixture(scope="module")
def pages_beside(browser: Browser, tmp_path_factory) -> Iterator[tuple[Page, str]]:
    """A page, and the address of a program with lessons that asks for a token."""
    file = tmp_path_factory.mktemp("student") / "my_filter.py"
    words = ("learn", "1", "--robot", "kinematic", "--map", "stub", "--port", "0")
    with started(*words, "--file", str(file), says=r"(http://[^\s]+)/learn/1") as (_, address):
        context = browser.new_context(reduced_motion="reduce")
        context.set_default_timeout(PATIENCE_MS)
        made = context.new_page()
        # The dashboard beside a lesson is looked at above.
        made.route(re.compile(r"//[^/]+/$"), lambda route: route.fulfill(body="<p>dashboard</p>"))
        yield made, address
        context.close()


FILLED = {"/learn/1": "#lessons [aria-current]", "/lens": "#language option"}
"""Other pages, and what each of them shows last."""


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("path", FILLED)
def test_the_other_pages(pages_beside, look, path):
    page, address = pages_beside
    page.emulate_media(color_scheme="null", forced_colors="null")
    page.emulate_media(**LOOKS[look])
    found = []
    for size in SIZES:
        show(page, size)
        page.goto(f"{address}{path}")
        expect(page.locator(FILLED[path]).first).to_be_attached()
        found += [f"{size}, {fault}" for fault in faults(page)]
    assert not found, "\n".join(found)


def test_the_page_that_asks_for_a_token(browser: Browser):
    words = ("run", "--robot", "kinematic", "--map", "stub", "--port", "0")
    with started(*words, "--token", "only-for-friends", says=r"(http://[^\s/?]+)") as (_, address):
        page = browser.new_page()
        page.goto(address)
        expect(page.get_by_role("button", name="Open")).to_be_visible()
        found = []
        for look in LOOKS.values():
            page.emulate_media(**{"color_scheme": "null", "forced_colors": "null"} | look)
            found += faults(page)
        page.close()
    assert not found, "\n".join(found)
