"""Where the panels are: ready layouts, borders, swaps, enlarging, links; and the map's size."""

import json
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
def shared(browser, server):
    """One page for all; each test begins with a ready layout."""
    yield from opened(browser, server, width=1280, height=720, view=False)


@pytest.fixture
def page(shared):
    choose(shared, "drive")
    return shared


def choose(page: Page, name: str) -> None:
    page.evaluate(f"document.querySelector('[data-layout={name}]').click()")


def box(page: Page, selector: str) -> dict:
    found = page.locator(selector).bounding_box()
    assert found is not None
    return found


def columns(page: Page, selector: str) -> tuple[float, float]:
    """Left side and width of an element: a banner may move it down meanwhile."""
    place = box(page, selector)
    return place["x"], place["width"]


def field_side(page: Page) -> float:
    """Side of the field's free part on the screen [CSS px]: here, the square of tape's."""
    left, right = page.evaluate(
        "[window.brickpose.mapPixel(-0.75, 0), window.brickpose.mapPixel(0.75, 0)]"
    )
    return right[0] - left[0]


@pytest.mark.parametrize(("name", "least"), [("drive", 300), ("understand", 420), ("present", 420)])
def test_the_field_is_large_on_a_laptop_and_nothing_lies_on_it(page, name, least):
    choose(page, name)
    page.wait_for_timeout(100)
    assert field_side(page) >= least
    stage = box(page, ".map-stage")
    assert min(stage["width"], stage["height"]) >= least
    legend = box(page, "#map .legend")
    beside = legend["x"] >= stage["x"] + stage["width"] - 1
    assert beside or legend["y"] >= stage["y"] + stage["height"] - 1
    # All of the free part is in sight.
    corners = page.evaluate(
        "[[-0.525, -0.525], [0.525, 0.525]].map(([x, y]) => window.brickpose.mapPixel(x, y))"
    )
    for u, v in corners:
        assert stage["x"] <= u <= stage["x"] + stage["width"]
        assert stage["y"] <= v <= stage["y"] + stage["height"]


def test_the_header_is_one_row_and_the_page_does_not_scroll(page):
    expect(page.locator("#stat-delay")).to_contain_text("ms")
    assert box(page, "header.bar")["height"] < 50
    tall, wide = page.evaluate(
        "[document.documentElement.scrollHeight, document.documentElement.scrollWidth]"
    )
    assert (tall, wide) == (720, 1280)


@pytest.mark.parametrize(("width", "height"), [(1280, 720), (1600, 1000)])
def test_longer_words_leave_the_header_one_row_and_tools_in_reach(browser, server, width, height):
    for page in opened(browser, server, width=width, height=height, view=False, locale="de-DE"):
        expect(page.locator("#stat-delay")).to_contain_text("ms")
        # The numbers may take a second row, for who asked for them.
        assert box(page, "header.bar")["height"] < 90
        page.locator("[data-more-of=bar]").click()
        assert box(page, "header.bar")["height"] < 50
        handles = box(page, "#plots .handles")
        for tool in ("#plots-span", "#plots-values", "#plots-log", "#plots-save"):
            place = box(page, tool)
            beside = place["x"] + place["width"] <= handles["x"]
            assert beside or place["y"] >= handles["y"] + handles["height"]


def test_a_panel_is_enlarged_by_a_click_and_escape_goes_back(page):
    before = columns(page, "#plots")
    page.locator("#plots .enlarge").click()
    assert box(page, "#plots")["width"] > 1200
    expect(page.locator("#map")).to_be_hidden()
    page.keyboard.press("Escape")
    expect(page.locator("#map")).to_be_visible()
    assert columns(page, "#plots") == before
    assert page.evaluate("document.activeElement.matches('#plots .enlarge')")


def test_escape_that_lays_a_tool_down_leaves_the_panel_large(page):
    page.locator("#map .enlarge").click()
    page.locator("[data-tool=set_pose]").click()
    page.locator("#map-canvas").focus()
    page.keyboard.press("Escape")
    expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#plots")).to_be_hidden()
    page.keyboard.press("Escape")
    expect(page.locator("#plots")).to_be_visible()


@pytest.mark.parametrize("how", ["pointer", "keys"])
def test_a_border_is_moved(page, how):
    before = box(page, "#map")["width"]
    border = page.get_by_role("separator", name="Border between map and camera")
    if how == "keys":
        border.focus()
        page.keyboard.press("ArrowLeft")
    else:
        at = border.bounding_box()
        page.mouse.move(at["x"] + 4, at["y"] + 40)
        page.mouse.down()
        page.mouse.move(at["x"] - 60, at["y"] + 40, steps=3)
        page.mouse.up()
    assert box(page, "#map")["width"] < before - 10
    # A robot does not drive by the keys that move a border.
    assert page.evaluate("window.brickpose.telemetry.mode") == "idle"


@pytest.mark.parametrize("how", ["pointer", "keys"])
def test_two_panels_are_swapped(page, how):
    was = columns(page, "#map")
    handle = page.locator("#map .move")
    if how == "keys":
        handle.focus()
        page.keyboard.press("ArrowRight")
    else:
        start, goal = handle.bounding_box(), box(page, "#camera")
        page.mouse.move(start["x"] + 8, start["y"] + 8)
        page.mouse.down()
        page.mouse.move(goal["x"] + 100, goal["y"] + 100, steps=4)
        page.mouse.up()
    assert columns(page, "#camera") == was


def test_the_layout_is_kept_and_shared_by_a_link_or_a_file(browser, server, page, tmp_path):
    choose(page, "present")
    page.locator("#layout-open").click()
    page.locator("#layout-panels [data-panel=plots]").click()
    expect(page.locator("#plots")).to_be_hidden()
    with page.expect_download() as download:
        page.locator("#layout-save").click()
    tree = json.loads(download.value.path().read_text())
    assert tree["tree"]["parts"] == ["map", "camera"]
    page.locator("#layout-close").click()
    page.reload()
    expect(page.locator("#camera")).to_be_visible()
    expect(page.locator("#plots")).to_be_hidden()
    file = tmp_path / "other.json"
    tree["tree"]["parts"] = ["plots", "map"]
    file.write_text(json.dumps(tree))
    page.locator("#layout-file").set_input_files(file)
    expect(page.locator("#plots")).to_be_visible()
    expect(page.locator("#camera")).to_be_hidden()
    link = f"{server.url}/#layout={json.dumps(tree)}"
    with browser.new_context(viewport={"width": 900, "height": 700}) as other:
        guest = other.new_page()
        guest.route("**/view/**", lambda route: route.fulfill(body=""))
        guest.goto(link)
        expect(guest.locator("#plots")).to_be_visible()
        expect(guest.locator("#filter")).to_be_hidden()
        assert "#" not in guest.url


@pytest.mark.parametrize("text", ["%", '{"kind": "brickpose-layout-1", "tree": {"split": "row", '
                         '"shares": [1e308, 1e308], "parts": ["map", "drive"]}}'])  # fmt: skip
def test_a_link_that_is_no_layout_is_told_and_the_page_works(browser, server, text):
    for page in opened(browser, server, width=1280, height=720, view=False):
        page.evaluate("link => { location.hash = link; location.reload(); }", f"#layout={text}")
        expect(page.locator("#toasts")).to_contain_text("This")
        expect(page.locator("#map")).to_be_visible()


def test_a_file_that_is_no_layout_is_refused_in_words(page, tmp_path):
    file = tmp_path / "bad.json"
    file.write_text('{"kind": "brickpose-layout-1", "tree": "kitchen"}')
    page.locator("#layout-file").set_input_files(file)
    expect(page.locator("#toasts")).to_contain_text("There is no panel kitchen; valid are map")
    expect(page.locator("#filter")).to_be_visible()


class TestNeverStuck:
    def test_a_robot_that_leaves_is_followed_and_brought_back(self, page, server):
        with server.live() as live:
            ask(live, type="place", x=0.7, y=0.7, theta=0.7)
            expect(page.locator("#map-away")).to_contain_text("has left the field")
            stage = box(page, ".map-stage")
            u, v = page.evaluate("window.brickpose.mapPixel(0.7, 0.7)")
            assert stage["x"] < u < stage["x"] + stage["width"]
            assert stage["y"] < v < stage["y"] + stage["height"]
            page.locator("#map-away button").click()
            now = until(live, lambda now: abs(now["truth"]["x"]) < 1e-6)
            assert now["mode"] == "idle"
            until(live, lambda now: now["estimate"] and abs(now["estimate"]["x"]) < 0.1)
            expect(page.locator("#map-away")).to_be_empty()

    def test_tools_are_laid_down_after_use(self, page):
        page.locator("[data-tool=place]").click()
        u, v = page.evaluate("window.brickpose.mapPixel(0.1, 0.1)")
        page.mouse.click(u, v)
        expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
        expect(page.locator("#map-hint")).to_contain_text("The filter does not know")

    def test_two_presses_measure(self, page):
        page.locator("button[data-tool=measure]").click()
        for x in (-0.1, 0.2):
            page.mouse.click(*page.evaluate(f"window.brickpose.mapPixel({x}, 0.1)"))
            if x < 0:
                expect(page.locator("button[data-tool=measure]")).to_have_attribute(
                    "aria-pressed", "true"
                )
        expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
        expect(page.locator("#map-measured")).to_have_text(
            re.compile(r"^(29[6-9]|30[0-4]) mm$")  # a pixel is 3 mm
        )
        page.locator("#map-clear").click()
        expect(page.locator("#map-measured")).to_be_empty()

    def test_keys_measure_and_do_not_drive_meanwhile(self, page):
        page.locator("button[data-tool=measure]").focus()
        page.keyboard.press("Enter")
        assert page.evaluate("document.activeElement.id") == "map-canvas"
        for key in ("ArrowLeft", "Enter", "ArrowRight", "ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
        side = page.evaluate(
            "(() => { const at = window.brickpose.mapPixel; return at(1, 0)[0] - at(0, 0)[0]; })()"
        )
        expect(page.locator("#map-measured")).to_have_text(f"{round(10e3 * 5**0.5 / side)} mm")
        page.keyboard.press("Enter")
        expect(page.locator("button[data-tool=look]")).to_have_attribute("aria-pressed", "true")
        assert page.evaluate("window.brickpose.telemetry.mode") == "idle"

    def test_the_figure_eight_says_where_it_does_not_fit_and_obeys_the_speed(self, page, server):
        def wait(condition) -> None:
            with server.live() as live:
                until(live, condition)

        pose = {"x": 0.35, "y": -0.35, "theta": -1.57}
        with server.live() as live:
            ask(live, type="place", **pose)
            ask(live, type="set_pose", **pose, sd_xy=0.002, sd_theta=0.02)
        # The newest telemetry may still be of the place before.
        wait(
            lambda now: (
                now["estimate"]
                and abs(now["estimate"]["x"] - pose["x"]) < 0.05
                and now["integrity"]["state"] in ("certain", "approximate", "given")
            )
        )
        page.locator("#figure-eight").click()
        expect(page.locator("#toasts")).to_contain_text("the figure-eight would leave the field")
        expect(page.locator("#figure-eight")).to_have_attribute("aria-pressed", "false")
        page.locator("#home").click()
        wait(lambda now: now["estimate"] and abs(now["estimate"]["x"]) < 0.1)
        page.locator("#speed").fill("0.25")
        page.locator("#figure-eight").click()
        wait(lambda now: abs(now["twist"]["v"] - 0.25) < 1e-6)
        page.locator("#speed").fill("0.1")
        wait(lambda now: abs(now["twist"]["v"] - 0.1) < 1e-6)
        page.locator("#stop").click()
        wait(lambda now: now["mode"] == "idle")


def test_a_box_that_opens_closes_what_it_would_lie_on(page):
    field, layout, calibration = (
        page.locator(f"#{name}") for name in ("field", "layout", "calibration")
    )
    for name in ("calibration", "field", "layout"):
        page.locator(f"#{name}-open").click()
    expect(field).to_be_hidden()
    expect(page.locator("#field-open")).to_have_attribute("aria-expanded", "false")
    expect(layout).to_be_visible()
    expect(calibration).to_be_visible()
    page.keyboard.press("Escape")
    expect(layout).to_be_hidden()
    expect(page.locator("#layout-open")).to_be_focused()
    page.locator("#calibration-close").click()
    expect(calibration).to_be_hidden()


def test_only_parameters_that_are_used_can_be_changed(page, server):
    def usable(name: str):
        return expect(page.locator(f"[name={name}]").first)

    usable("velocity_alpha1").to_be_disabled()
    usable("alpha1").to_be_enabled()
    page.locator("select[name=robot_model_type]").select_option("velocity")
    usable("velocity_alpha1").to_be_enabled()
    usable("alpha1").to_be_disabled()
    page.locator("select[name=filter]").select_option("kalman")
    usable("max_particles").to_be_disabled()
    expect(page.locator("#filter-hint")).to_contain_text("no particles")
    page.locator("#reset").click()
    usable("max_particles").to_be_enabled()
