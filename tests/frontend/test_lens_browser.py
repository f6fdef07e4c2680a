"""A lens is calibrated on the page, in a real Chromium; and the floor's grid is seen there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from board_pictures import CHESSBOARD, lens_of, picture, poses
from board_robot import board_robot
from browsing import PATIENCE_MS, show_all
from playwright.sync_api import Browser, Page, expect

from app.features.calibration.lens import desk
from app.page.tokens import Tokens
from app.settings.profiles import own_profile
from robot.description.profile import load_profile
from robot.lens_files.reading import read_lens_file

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LENS = lens_of()
PICTURES = 8
NAMELESS = """() => [...document.querySelectorAll("button, input, select, canvas, progress, a")]
  .filter(e => e.checkVisibility() && !(e.ariaLabel || e.textContent.trim() || e.labels?.length))
  .map(e => e.outerHTML.slice(0, 120))"""
"""Controls whose purpose a screen reader cannot tell."""


@contextmanager
def page_at(browser: Browser, address: str, path: str) -> Iterator[Page]:
    context = show_all(browser.new_context(viewport={"width": 1100, "height": 760}))
    context.set_default_timeout(PATIENCE_MS)
    complaints: list[str] = []
    page = context.new_page()
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.route("**/view/**", lambda route: route.fulfill(body="<p>no 3D here</p>"))
    page.goto(f"http://{address}{path}")
    yield page
    context.close()
    assert not complaints


def bar(page: Page, name: str) -> float:
    value: float = page.locator(f"#bar-{name}").evaluate("bar => bar.value")
    return value


def value_of(page: Page, parameter: str) -> float:
    row = page.locator("#parameters tr", has=page.get_by_text(parameter, exact=True))
    return float(row.locator("td").nth(1).inner_text().replace("−", "-"))


def test_a_lens_is_calibrated_on_the_page(browser, monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(desk, "PERIOD_S", 0.05)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    rng = np.random.default_rng(4)
    pictures = [picture(CHESSBOARD, pose, rng) for pose in poses(CHESSBOARD, LENS, PICTURES, rng)]
    opened = board_robot(real=True)
    with opened as (robot, address), page_at(browser, address, "/lens") as page:
        verdict, taken = page.locator("#verdict"), page.locator("#taken")
        expect(verdict).to_have_text("Choose the board, then start.")
        page.get_by_role("button", name="Start").click()
        expect(page.locator("#board-fields")).not_to_have_attribute("open", "")
        expect(verdict).to_contain_text("No chessboard of 9 x 6 inner corners in sight")
        expect(page.locator("#steps li").first).to_contain_text("upper left corner")
        assert [bar(page, name) for name in ("x", "y", "size", "tilt")] == [0, 0, 0, 0]

        robot.shown = pictures[0]
        expect(verdict).to_have_text("Picture 1 taken.")
        assert bar(page, "x") > 0 and bar(page, "tilt") > 0
        page.get_by_role("button", name="Calibrate").click()
        words = page.locator("#calibrate-words")
        expect(words).to_have_text("1 pictures of 1 are of use; valid are 6 or more.")
        robot.shown = np.asarray(cv2.GaussianBlur(pictures[1], (0, 0), 4))
        expect(verdict).to_contain_text("Blurred: edges are")

        for number, shown in enumerate(pictures[1:], 2):
            robot.shown = shown
            expect(taken).to_have_text(str(number))
        page.get_by_role("button", name="Calibrate").click()
        expect(page.locator("#result-model")).to_have_text("plumb_bob")
        assert value_of(page, "fx") == pytest.approx(LENS.matrix[0, 0], abs=3)
        assert value_of(page, "cy") == pytest.approx(LENS.matrix[1, 2], abs=3)
        chosen = page.locator("#ratings tr[data-chosen=true] td").nth(1).inner_text()
        assert float(chosen.removesuffix(" px")) < 0.2
        assert drawn(page, "#errors") > 500 and drawn(page, "#coverage") > 500
        with page.expect_download() as download:
            page.get_by_role("link", name="camera_info").click()
        download.value.save_as(tmp_path / "camera.yaml")
        assert read_lens_file(Path(tmp_path / "camera.yaml")).lens.matrix[0, 0] == pytest.approx(
            value_of(page, "fx"), abs=0.01
        )

        page.get_by_role("button", name="Save").click()
        expect(page.locator("#save-words")).to_contain_text("is used from the next start on")
        profile = load_profile(own_profile(robot.spec.name))
        assert profile.lens is not None and profile.source == f"lens by {PICTURES} pictures"

        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.evaluate(NAMELESS) == []
        page.reload()
        expect(taken).to_have_text(str(PICTURES))
        expect(page.locator("#result-model")).to_have_text("plumb_bob")


def test_a_board_that_there_is_not_is_told_and_can_be_mended(browser) -> None:
    with board_robot() as (_, address), page_at(browser, address, "/lens") as page:
        page.locator("#board-kind").select_option("charuco")
        page.locator("#board-dictionary").select_option("4x4_50")
        page.locator("#board-columns").fill("30")
        page.get_by_role("button", name="Start").click()
        expect(page.locator("#banner")).to_contain_text("there are 50 of 4x4_50")
        page.locator("#board-kind").select_option("chessboard")
        page.locator("#board-columns").fill("10")
        page.get_by_role("button", name="Start").click()
        expect(page.locator("#verdict")).to_contain_text("No chessboard of 9 x 6")
        expect(page.locator("#banner")).to_be_empty()


def drawn(page: Page, canvas: str) -> int:
    """How many pixels of a canvas are not empty."""
    count: int = page.locator(canvas).evaluate(
        """canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height)
            .data.filter((value, i) => i % 4 === 3 && value > 0).length"""
    )
    return count


def test_whoever_only_watches_is_told(browser) -> None:
    tokens, path = Tokens("drive-me", "watch-me"), "/lens?token=watch-me"
    with board_robot(tokens) as (_, address), page_at(browser, address, path) as page:
        expect(page.get_by_role("button", name="Save")).to_be_hidden()  # no real robot
        expect(page.locator("#banner")).to_contain_text("This link only watches")
        page.get_by_role("button", name="Start").click()
        expect(page.locator("#banner")).to_contain_text("no connection")


GRID_LINES = """() => {
  const canvas = document.querySelector("#camera-canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const near = (i, value) => Math.abs(data[i] - value) < 24;
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    count += near(i, 0x00) && near(i + 1, 0x70) && near(i + 2, 0x7f);
  }
  return count;
}"""
"""How many pixels of the camera's picture have the colour of the grid."""


def test_the_floors_grid_is_drawn_over_the_picture(browser) -> None:
    with board_robot() as (_, address), page_at(browser, address, "/") as page:
        page.wait_for_function("window.brickpose?.connected && window.brickpose.delays.length")
        page.locator("#camera-rays").click()
        page.wait_for_function(f"({GRID_LINES})() === 0")
        page.get_by_role("button", name="floor grid").click()
        page.wait_for_function(f"({GRID_LINES})() > 20")
        page.get_by_role("button", name="floor grid").click()
        page.wait_for_function(f"({GRID_LINES})() === 0")
