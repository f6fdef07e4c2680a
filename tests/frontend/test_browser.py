"""The page in a real Chromium: driving, telling a pose, and stopping when the page goes away."""

import json
import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import cv2
import numpy as np
import pytest
from browsing import PATIENCE_MS, SOFTWARE_GL, let_go, opened
from playwright.sync_api import Page, expect
from serving import ask, pose_error, serving, telemetry, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    with serving("--map", "square", "--seed", "3") as running:
        yield running


@pytest.fixture
def live(server):
    with server.live() as socket:
        yield socket


@pytest.fixture
def page(browser, server) -> Iterator[Page]:
    """The page without its 3D part, which software WebGL draws too slowly for the rest."""
    yield from opened(browser, server, width=1100, height=760, view=False)


def distance(one: dict, other: dict) -> float:
    return math.dist((one["x"], one["y"]), (other["x"], other["y"]))


class TestDriving:
    """On one page: it is as before when the robot stands again."""

    @pytest.fixture(scope="class")
    @classmethod
    def page(cls, browser, server) -> Iterator[Page]:
        yield from opened(browser, server, width=1100, height=760, view=False)

    @pytest.mark.parametrize("key", ["w", "ArrowUp"])
    def test_a_key_drives_and_its_release_stops(self, page, live, key):
        before = telemetry(live)
        page.keyboard.down(key)
        until(live, lambda now: now["twist"]["v"] > 0.1)
        page.keyboard.up(key)
        let_go(page)
        after = until(live, lambda now: now["twist"]["v"] == 0 and now["mode"] == "idle")
        assert distance(before["truth"], after["truth"]) > 0.003

    def test_two_keys_drive_a_curve(self, page, live):
        page.keyboard.down("w")
        page.keyboard.down("a")
        until(live, lambda now: now["twist"]["v"] > 0.02 and now["twist"]["omega"] > 0.1)
        page.keyboard.up("w")
        page.keyboard.up("a")
        let_go(page)
        until(live, lambda now: now["mode"] == "idle")

    @pytest.mark.parametrize("how", ["button", "space"])
    def test_stop_ends_the_figure_eight(self, page, live, how):
        page.get_by_role("button", name="Figure-eight").click()
        until(live, lambda now: now["mode"] == "figure_eight" and now["twist"]["v"] > 0.1)
        if how == "button":
            page.get_by_role("button", name="STOP").first.click()
        else:
            page.keyboard.press("Space")
        still = until(live, lambda now: now["mode"] == "idle")
        assert still["twist"]["v"] == 0
        assert until(live, lambda now: now["stamp"] > still["stamp"] + 0.6)["mode"] == "idle"

    @pytest.mark.parametrize("name", ["Figure-eight", None])
    def test_back_to_start_ends_what_drives(self, page, live, name):
        """Of this page, whose next renewal would drive on, or of another program."""
        if name:
            page.get_by_role("button", name=name).click()

        def drives(now) -> bool:
            if not name:
                live.send(json.dumps({"type": "figure_eight"}))
            return now["mode"] == "figure_eight" and abs(now["truth"]["x"]) > 0.03

        until(live, drives)
        page.locator("#home").click()
        still = until(live, lambda now: now["mode"] == "idle")
        later = until(live, lambda now: now["stamp"] > still["stamp"] + 0.6)
        assert later["mode"] == "idle"
        assert math.hypot(later["truth"]["x"], later["truth"]["y"]) < 0.002
        expect(page.locator("#figure-eight")).to_have_attribute("aria-pressed", "false")

    def test_the_joystick_drives(self, page, live):
        box = page.locator("#joystick").bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        knob = page.locator("#knob")
        rest = knob.bounding_box()
        still = knob.evaluate("(knob) => getComputedStyle(knob).translate")
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0], middle[1] - box["height"] / 3, steps=3)
        until(live, lambda now: now["twist"]["v"] > 0.03)
        until(live, lambda now: knob.bounding_box()["y"] < rest["y"] - box["height"] / 6)
        page.mouse.up()
        let_go(page)
        until(live, lambda now: now["mode"] == "idle")
        expect(knob).to_have_css("translate", still)


def test_keys_do_not_drive_while_a_number_is_typed(page, live):
    page.get_by_role("button", name="type a pose").click()
    page.locator("#pose-x").click()
    page.keyboard.down("ArrowUp")
    page.wait_for_timeout(300)
    assert telemetry(live)["mode"] == "idle"
    page.keyboard.up("ArrowUp")


def test_typed_numbers_move_the_robot_and_undo_restores_the_pose(page, live):
    ask(live, type="place", x=-0.25, y=0.2, theta=0)
    ask(live, type="set_pose", x=-0.25, y=0.2, theta=0)
    page.get_by_role("button", name="type a pose").click()
    page.locator("#pose-x").fill("150")
    page.locator("#pose-y").fill("-100")
    page.locator("#pose-heading").fill("90")
    page.locator("#numbers-place").click()
    moved = until(live, lambda now: abs(now["truth"]["x"] - 0.15) < 1e-3)
    assert moved["truth"]["theta"] == pytest.approx(math.pi / 2, abs=1e-3)
    page.get_by_role("button", name="pause", exact=True).click()
    was = until(live, lambda now: now["filter"]["paused"] and now["estimate"])["estimate"]
    assert math.dist((was["x"], was["y"]), (0.15, -0.1)) > 0.1
    page.locator("#numbers-set").click()
    until(live, lambda now: pose_error(now) < 0.03)
    page.get_by_role("button", name="undo").click()
    until(live, lambda now: now["estimate"] == was)
    page.get_by_role("button", name="resume", exact=True).click()
    until(live, lambda now: not now["filter"]["paused"])


def test_a_parameter_is_changed_and_reset_brings_it_back(page, live):
    number = page.get_by_role("textbox", name="max_particles").first
    number.fill("700")
    with page.expect_response("**/api/parameters"):
        number.press("Enter")
    page.get_by_role("button", name="scatter", exact=True).first.click()
    until(live, lambda now: now["particles"]["count"] == 700)
    page.get_by_role("button", name="reset", exact=True).first.click()
    until(live, lambda now: now["particles"]["count"] != 700)


def test_a_slider_changes_a_parameter_and_the_number_beside_it(page):
    slider, number = (
        page.locator(f"input[name=z_rand][type={kind}]") for kind in ("range", "text")
    )
    before = number.input_value()
    slider.fill("0")
    expect(number).not_to_have_value(before)
    lowest = number.input_value()
    page.wait_for_function("window.told.some((text) => text.includes('set_parameters'))")
    page.reload()
    expect(number).to_have_value(lowest)
    page.get_by_role("button", name="reset", exact=True).first.click()
    expect(number).to_have_value(before)


def test_a_ray_shows_its_profile(page, live):
    ask(live, type="place", x=0.2, y=0, theta=0)  # the ray in the middle crosses the tape
    page.locator("#camera-profile").click()
    expect(page.locator("#profile")).to_be_visible()
    expect(page.locator("#profile-text")).to_contain_text("mm")
    page.locator("#profile-close").click()
    expect(page.locator("#profile")).to_be_hidden()
    expect(page.locator("#camera-profile")).to_have_attribute("aria-pressed", "false")
    page.locator("#camera-rays").click()
    expect(page.locator("#camera-rays")).to_have_attribute("aria-pressed", "false")


def test_the_3d_view_shows_the_scene(chromium, server):
    browser = chromium(SOFTWARE_GL)
    for page in opened(browser, server, width=760, height=620, view=True):
        page.locator("#view .enlarge").click()
        frame = page.frame_locator("iframe")
        frame.locator("canvas").first.wait_for()
        dark = 0.0
        for _ in range(400):  # software WebGL takes its time
            # What is around the frame: the page makes a new frame when it finds the server again.
            shot = page.locator("#view-stage").screenshot()
            picture = cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_GRAYSCALE)
            dark = float((picture < 80).mean())
            if dark > 0.005:
                break
            page.wait_for_timeout(250)
        assert dark > 0.005, "no dark tape in the 3D view"
    browser.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_a_phone_the_panels_are_tabs_and_stop_is_always_there(browser, server, scheme):
    for page in opened(
        browser, server, width=390, height=844, view=False, has_touch=True,
        color_scheme=scheme,
    ):  # fmt: skip
        page.evaluate(
            """document.getElementById("main").insertAdjacentHTML("beforeend", `
                <section class="panel" id="tabless"><h2>No tab</h2></section>
                <section class="panel" id="sharing" data-tab="camera"><h2>Shares</h2></section>`)"""
        )
        shown = {}
        for tab in page.get_by_role("tablist", name="Panels").get_by_role("tab").all():
            tab.click()
            expect(page.locator(f"#{tab.get_attribute('aria-controls')}")).to_be_visible()
            assert any(
                button.is_visible() for button in page.get_by_role("button", name="STOP").all()
            )
            expect(page.locator("#joystick")).to_be_visible()
            shown[tab.text_content()] = page.evaluate(
                "[...document.querySelectorAll('main > .panel')]"
                ".filter(panel => panel.checkVisibility()).map(panel => panel.id)"
            )
            boxes = [page.locator(f"#{name}").bounding_box() for name in shown[tab.text_content()]]
            boxes.sort(key=lambda box: box["y"])
            assert all(a["y"] + a["height"] <= b["y"] for a, b in pairwise(boxes))
        assert {"camera", "sharing"} <= set(shown["Camera"])
        assert {"filter", "plots"} <= set(shown["Filter"])
        times = Counter(name for names in shown.values() for name in names)
        assert times.pop("drive") == len(shown)
        assert set(times.values()) == {1}
        panels = page.evaluate(
            "[...document.querySelectorAll('main > .panel')].map(panel => panel.id)"
        )
        # Motion is not measured in pictures: that panel takes no room.
        hidden = {"tabless", "picture_odometry-floor"}
        assert set(panels) - set().union(*shown.values()) == hidden
        wide = page.evaluate("document.documentElement.scrollWidth")
        assert wide <= 390


def test_every_control_has_a_name(page):
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, canvas, [tabindex]')]
            .filter(e => e.checkVisibility() && !(e.ariaLabel || e.textContent.trim() || e.title
              || e.labels?.length || e.getAttribute('aria-labelledby')))
            .map(e => e.outerHTML.slice(0, 120))"""
    )
    assert nameless == []


def test_a_server_that_goes_and_comes_is_found_again(browser):
    options = ("--robot", "kinematic", "--map", "stub")
    with serving(*options) as first:
        context = browser.new_context(viewport={"width": 900, "height": 700})
        context.set_default_timeout(PATIENCE_MS)
        page = context.new_page()
        page.route("**/view/**", lambda route: route.fulfill(body=""))
        page.goto(first.url)
        page.wait_for_function("window.brickpose?.connected")
        port = first.address.split(":")[1]
    page.wait_for_function("!window.brickpose.connected")
    with serving(*options, "--port", port):
        page.wait_for_function("window.brickpose.connected")
        context.close()
