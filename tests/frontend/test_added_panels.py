"""Panels of other packages' features: on a phone they have their height, and a failure shows."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from browsing import PATIENCE_MS, visit
from playwright.sync_api import Browser, expect
from serving import ROOT, serving

pytestmark = [pytest.mark.browser, pytest.mark.slow]

FEATURE = """
from pathlib import Path
from app.feature import Feature, Panel
HERE = Path(__file__).parent
PANELS = tuple(Panel(f"lamp{n}", f"Lamp {n}", HERE / "page" / "lamp.js") for n in range(3))
BROKEN = Panel("dark", "Dark", HERE / "page" / "dark.js")
FEATURE = Feature(name="lamps", about="lamps", panels=(*PANELS, BROKEN))
"""
LAMP = """
export function panel(body) {
  for (let n = 0; n < 5; n++) body.append(Object.assign(document.createElement("p"),
    { textContent: `lamp ${n}` }));
  return { show() {} };
}
"""


@pytest.fixture
def lamps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    about = tmp_path / "lamps-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: lamps\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[brickpose.features]\nlamps = lamps:FEATURE\n")
    (tmp_path / "lamps.py").write_text(FEATURE)
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "lamp.js").write_text(LAMP)
    (tmp_path / "page" / "dark.js").write_text('throw new Error("no bulb");')
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path), str(ROOT))))


def test_they_have_their_height_on_a_phone_and_a_failure_shows(
    browser: Browser, lamps: None
) -> None:
    with serving("--robot", "kinematic") as server:
        for size in ({"width": 1400, "height": 900}, {"width": 390, "height": 700}):
            with browser.new_context(viewport=size) as context:
                context.set_default_timeout(PATIENCE_MS)
                page = context.new_page()
                page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
                page.goto(server.url)
                told = page.locator("#toasts").get_by_text("The panel Dark has failed (")
                expect(told).to_contain_text("Error: no bulb")
                visit(page, server.url)
        with browser.new_context(viewport={"width": 390, "height": 700}) as context:
            context.set_default_timeout(PATIENCE_MS)
            page = context.new_page()
            page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
            visit(page, server.url)
            page.locator("[role=tab][data-name=map]").click()
            for number in range(3):
                panel = page.locator(f"#lamps-lamp{number}")
                expect(panel.get_by_text("lamp 4")).to_have_count(1)
                panel.scroll_into_view_if_needed()
                seen = panel.evaluate("each => [each.clientHeight, each.scrollHeight]")
                assert seen[0] == seen[1] > 140
            stop = page.locator("#drive").bounding_box()
            assert stop is not None
            assert stop["y"] + stop["height"] <= 700
