"""The editor of fields: somebody draws one in the page, and the robot drives on it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from axe import LOOK_RULES, needs_axe, violations
from browsing import LOOKS, PATIENCE_MS
from playwright.sync_api import Browser, Page, expect
from serving import ask, drive_until, serving, until

from robot.fields.svg_field import load_svg

pytestmark = [pytest.mark.browser, pytest.mark.slow]

TWO_MINUTES_S = 120.0
WIDTHS = (360, 768, 1366, 1920)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("drawn")


@pytest.fixture(scope="module")
def server(folder):
    config = folder.parent / "field_editor.toml"
    config.write_text(f'[mapping]\nfolder = "{folder}"\n')
    with serving("--map", "square", "--robot", "kinematic", "--config", str(config)) as running:
        yield running


def editors(browser: Browser, server, **options) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": 1366, "height": 768}, **options)
    context.set_default_timeout(PATIENCE_MS)
    complaints: list[str] = []
    page = context.new_page()
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(f"{server.url}/field_editor")
    expect(page.locator("#open option")).not_to_have_count(1)
    yield page
    context.close()
    assert not complaints, complaints


@pytest.fixture
def page(browser, server) -> Iterator[Page]:
    yield from editors(browser, server)


def place(page: Page, x: float, y: float) -> tuple[float, float]:
    """Where on the screen a place of the floor [mm] is."""
    found = page.evaluate(
        """([x, y]) => { const place = new DOMPoint(x, -y).matrixTransform(
            document.querySelector("#stage").getScreenCTM()); return [place.x, place.y]; }""",
        [x, y],
    )
    return found[0], found[1]


def press(page: Page, x: float, y: float) -> None:
    page.mouse.click(*place(page, x, y))


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.mouse.move(*place(page, *start))
    page.mouse.down()
    page.mouse.move(*place(page, *((a + b) / 2 for a, b in zip(start, end, strict=True))))
    page.mouse.move(*place(page, *end))
    page.mouse.up()


def saved(page: Page, folder: Path, name: str):
    page.locator("#name").fill(name)
    page.locator("#save").click()
    expect(page.locator("#banner")).to_contain_text(f"{name} is kept")
    return load_svg(folder / f"{name}.svg")


def test_a_newcomer_draws_a_field_and_the_robot_drives_on_it(page: Page, server) -> None:
    begun = time.monotonic()
    expect(page.locator("#hint")).to_contain_text("drag a rectangle over the floor")
    drag(page, (-500, -400), (500, 400))
    page.locator("#name").fill("First field")
    page.locator("#drive").click()
    page.wait_for_url(f"{server.url}/", timeout=1000 * TWO_MINUTES_S)
    page.wait_for_function("window.brickpose?.telemetry?.map === 'First-field'")
    page.wait_for_function("window.brickpose?.telemetry?.estimate")
    with server.live() as live:
        now = drive_until(live, 0.15, lambda now: now["truth"]["x"] > 0.1)
        ask(live, type="stop")
        until(live, lambda now: now["mode"] == "idle")
    assert now["map"] == "First-field"
    assert time.monotonic() - begun < TWO_MINUTES_S


def test_lines_curves_and_numbers_become_tape_as_they_are_typed(page: Page, folder: Path) -> None:
    page.locator("[data-tool=curve]").click()
    for x, y in ((-300, 0), (300, 0), (0, 300)):
        press(page, x, y)
    page.keyboard.press("Enter")
    page.get_by_role("textbox", name="tape width").fill("37,5")
    page.keyboard.press("Tab")
    expect(page.get_by_role("textbox", name="tape width")).to_have_value("37.5")
    page.get_by_role("textbox", name="heading").fill("-90")
    page.get_by_role("textbox", name="y [mm]", exact=True).fill("-200")
    page.keyboard.press("Enter")
    width = page.get_by_role("textbox", name="width [mm]", exact=True)
    width.fill("5")
    page.keyboard.press("Enter")
    expect(width).to_have_value("1500")
    field = saved(page, folder, "half-circle")
    assert field.tape[0].width == pytest.approx(0.0375)
    assert field.start.y == pytest.approx(-0.2)
    assert field.start.theta == pytest.approx(-math.pi / 2)
    radii = [math.hypot(x, y) for x, y in field.edges.reshape(-1, 2).tolist() if y > 1e-6]
    assert min(radii) == pytest.approx(0.28125, abs=2e-4)
    assert max(radii) == pytest.approx(0.31875, abs=2e-4)
    ends = field.edges.reshape(-1, 2)
    assert ends[:, 1].min() == pytest.approx(0, abs=1e-4)


def test_tape_is_bent_moved_rounded_and_all_of_it_undone(page: Page, folder: Path) -> None:
    drag(page, (-400, -400), (400, 400))
    page.locator("[data-tool=select]").click()
    page.get_by_role("textbox", name="round its corners").fill("100")
    page.keyboard.press("Enter")
    expect(page.locator("#nodes tr")).to_have_count(8)
    page.keyboard.press("Control+z")
    page.locator("#stage").focus()
    page.keyboard.press("Control+z")
    expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(0)
    page.keyboard.press("Control+y")
    expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(1)
    press(page, -400, 200)
    expect(page.locator("#stage .middle")).to_have_count(4)
    drag(page, (0, -400), (0, -600))
    bend = page.get_by_role("textbox", name="bend after point 1")
    expect(bend).to_have_value("106.26")
    drag(page, (-400, 200), (-350, 250))
    expect(page.get_by_role("textbox", name="x of point 1")).to_have_value("−350")
    edges = saved(page, folder, "bent").edges.reshape(-1, 2)
    assert edges[:, 1].min() == pytest.approx(-0.575, abs=2e-4)
    page.keyboard.press("Delete")
    expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(0)
    page.reload()
    expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(0)
    expect(page.locator("#name")).to_have_value("bent")


def test_the_keyboard_alone_is_enough(page: Page, folder: Path) -> None:
    page.locator("#stage").focus()
    page.keyboard.press("l")
    for keys in ("Enter", *["ArrowRight"] * 6, "Enter", *["ArrowUp"] * 4, "Enter"):
        page.keyboard.press(keys)
    page.keyboard.press("Enter")  # where it is already: the tape ends
    expect(page.locator("#nodes tr")).to_have_count(3)
    edges = saved(page, folder, "by-keys").edges.reshape(-1, 2)
    assert edges.max(axis=0).tolist() == pytest.approx([0.325, 0.2])


def test_a_field_of_the_program_is_edited_as_a_copy(page: Page, folder: Path) -> None:
    page.goto(page.url + "?field=town")
    expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(12)
    expect(page.locator("#name")).to_have_value("town-copy")
    copy, town = saved(page, folder, "town-copy"), load_svg(Path("maps/town.svg"))
    assert copy.start == town.start
    xmin, ymin, xmax, ymax = town.extent
    assert copy.extent == pytest.approx((xmin, ymin, xmax, ymax))
    differ = abs(copy.floor.image.astype(int) - town.floor.image) > 60
    assert differ.mean() < 0.002
    page.locator("#name").fill("town")
    page.locator("#save").click()
    expect(page.locator("#banner")).to_contain_text("There is a field town already")


@needs_axe
@pytest.mark.parametrize("language", ["en-US", "de-DE"])
def test_it_looks_right_at_every_width_and_breaks_no_rule(browser, server, language) -> None:
    found: list[str] = []
    for page in editors(browser, server, locale=language, reduced_motion="reduce"):
        drag(page, (-400, -400), (400, 400))
        page.locator("[data-tool=select]").click()
        press(page, -400, 0)
        for name, look in LOOKS.items():
            page.emulate_media(**{"color_scheme": "null", "forced_colors": "null"} | look)
            rules = () if name == "light" else LOOK_RULES
            found += [f"{name}: {fault}" for fault in violations(page, "html", rules)]
        page.emulate_media(color_scheme="null", forced_colors="null")
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 800})
            for text in ("normal", "large"):
                page.evaluate("(text) => document.documentElement.dataset.text = text", text)
                wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
                tall = page.locator("#stage").bounding_box()
                if wide > 0 or not tall or tall["height"] < 200:
                    found.append(f"{width} {text}: {wide} px too wide, {tall}")
    assert found == []


def test_a_finger_draws(browser, server) -> None:
    for page in editors(browser, server, has_touch=True):
        page.set_viewport_size({"width": 390, "height": 844})
        page.locator("[data-tool=circle]").tap()
        page.touchscreen.tap(*place(page, 0, 0))
        page.touchscreen.tap(*place(page, 400, 0))
        expect(page.locator("#stage path.hit[data-stroke]")).to_have_count(1)
