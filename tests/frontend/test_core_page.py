"""The page of the core alone: it drives and localizes, and shows nothing of features left out."""

from __future__ import annotations

import pytest
from browsing import PATIENCE_MS, show_all, visit
from playwright.sync_api import Browser, expect
from serving import serving

from app.feature_search import find_features

pytestmark = [pytest.mark.browser, pytest.mark.slow]

CERTAIN = "window.brickpose?.telemetry?.integrity.state === 'certain'"
WITHOUT = [word for feature in find_features().active for word in ("--without", feature.name)]


def test_the_core_drives_and_is_certain_and_offers_nothing_else(browser: Browser) -> None:
    complaints: list[str] = []
    missing: list[str] = []
    with serving("--robot", "kinematic", *WITHOUT) as server, browser.new_context() as context:
        show_all(context).set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "response", lambda answer: missing.append(answer.url) if answer.status >= 400 else None
        )
        page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
        visit(page, server.url)
        page.get_by_role("button", name="Figure-eight").click()
        page.wait_for_function(CERTAIN)
        page.keyboard.press(" ")
        page.wait_for_function("window.brickpose.telemetry.mode === 'idle'")
        for absent in (
            "#record",
            "#recordings-open",
            "#calibration-open",
            "#mapping-open",
            "#camera-lens",
            "#by-hand",
            "button[data-tool=ask]",
        ):
            expect(page.locator(absent)).to_have_count(1)
            expect(page.locator(absent)).to_be_hidden()
        page.locator("#help-open").click()
        expect(page.locator("#help h3")).to_have_text(["Keys", "What is drawn"])
        expect(page.locator("#toasts")).to_be_empty()
    assert not complaints
    assert not missing
