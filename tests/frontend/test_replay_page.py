"""The page of a replay in a real Chromium."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browsing import opened
from playwright.sync_api import Page, expect
from replays import recorded_eight
from serving import ask, started, telemetry

from benchmarks.programs import ServedProgram

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    made, _ = recorded_eight(tmp_path_factory.mktemp("recordings"), seconds=6)
    words = "replay", str(made), "--paused", "--port", "0"
    with started(*words, says=r"http://([^\s/]+)") as (process, address):
        yield ServedProgram(process, address)


@pytest.fixture
def page(browser, server) -> Iterator[Page]:
    yield from opened(browser, server, width=1100, height=760, view=False)


@pytest.fixture
def live(server):
    with server.live() as socket:
        ask(socket, type="replay", paused=True, speed=1.0, position_s=2.0)
        until(socket, lambda now: abs(now["position_s"] - 2.0) < 0.03)
        yield socket


def until(socket, condition):
    """Where the replay stands once it has got there and a condition holds."""
    while True:
        now = telemetry(socket)["replay"]
        if now["catching_up"] is None and condition(now):
            return now


def test_a_bar_tells_the_time_and_nothing_can_be_driven(page, live):
    expect(page.locator("#replay")).to_be_visible()
    expect(page.locator("#replay-time")).to_have_text("0:02.0 / 0:05.9")
    expect(page.locator("#drive")).to_contain_text("A replay cannot be driven.")
    for gone in ("#stop", "#joystick", "#figure-eight", "button[data-tool=place]"):
        expect(page.locator(gone)).to_be_hidden()
    expect(page.locator("#map .legend")).to_contain_text("estimated then")
    answer = ask(live, type="drive", v=0.1, omega=0.0)
    assert answer["type"] == "error"
    assert "replay" in answer["message"]


def test_space_plays_and_pauses(page, live):
    page.keyboard.press("Space")
    until(live, lambda now: not now["paused"] and now["position_s"] > 2.1)
    expect(page.locator("#replay-play")).to_have_text("Pause")
    page.keyboard.press("Space")
    until(live, lambda now: now["paused"])
    expect(page.locator("#replay-play")).to_have_text("Play")


@pytest.mark.parametrize(
    ("on", "back"), [(".", ","), ("ArrowRight", "ArrowLeft")], ids=["marks", "arrows"]
)
def test_keys_go_from_picture_to_picture(page, live, on, back):
    page.keyboard.press(on)
    first = until(live, lambda now: now["position_s"] > 2.03)
    page.keyboard.press(on)
    second = until(live, lambda now: now["position_s"] > first["position_s"] + 0.01)
    page.keyboard.press(back)
    until(live, lambda now: now["position_s"] == first["position_s"] < second["position_s"])


def test_the_slider_scrubs_and_what_was_said_then_is_drawn_in_its_colour(page, live):
    # The slider gets its place once the page knows how long the replay is.
    expect(page.locator("#replay-time")).to_have_text("0:02.0 / 0:05.9")
    box = page.locator("#replay-position").bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 3, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.75 * box["width"], middle, steps=5)
    page.mouse.up()
    now = until(live, lambda now: 4.2 < now["position_s"] < 4.7)
    assert now["paused"]
    assert now["estimate_then"] is not None
    expect(page.locator("#replay-time")).to_contain_text("0:04.")


def test_a_replay_that_plays_goes_on_where_the_slider_is_let_go(page, live):
    page.locator("#replay-play").click()
    until(live, lambda now: not now["paused"] and now["position_s"] > 2.1)
    page.locator("#replay-position").fill("1")
    until(live, lambda now: not now["paused"] and 1.0 < now["position_s"] < 2.0)
    expect(page.locator("#replay-play")).to_have_text("Pause")
    page.locator("#replay-play").click()
    until(live, lambda now: now["paused"])


def test_the_speed_is_chosen_from_a_list(page, live):
    page.locator("#replay-speed").select_option("0.25")
    until(live, lambda now: now["speed"] == 0.25)


def test_on_a_phone_the_bar_lies_below_the_map(browser, server, live):
    for page in opened(browser, server, width=390, height=844, view=False):
        expect(page.locator("#drive")).to_be_hidden()
        bar, map_box = (page.locator(one).bounding_box() for one in ("#replay", "#map"))
        assert bar["y"] >= map_box["y"] + map_box["height"]
        assert bar["y"] + bar["height"] <= 844
        assert page.evaluate("document.documentElement.scrollWidth") == 390


def test_a_paused_recording_goes_through_the_filter_by_hand(page, live):
    """Standing at a picture, the filter takes its steps and takes them back."""
    ask(live, type="set_parameters", values={"filter": "particles"})
    page.wait_for_function("window.brickpose.telemetry.filter.kind === 'particles'")
    page.locator("#by-hand").click()
    box = page.locator("#particles .hand")
    box.get_by_role("button", name="by hand").click()
    expect(box.get_by_role("status")).to_contain_text("Begin with predict")
    page.locator("#replay-on").click()
    expect(box.locator(".quiet")).to_contain_text(
        "Since the last prediction the wheels have driven"
    )
    for step, words in (("predict", "noise drawn"), ("weigh", "effective"), ("resample", "died")):
        box.get_by_role("button", name=step).click()
        expect(box.get_by_role("status")).to_contain_text(words)
    for words in ("effective", "noise drawn", "Begin with predict"):
        box.get_by_role("button", name="back").click()
        expect(box.get_by_role("status")).to_contain_text(words)
    # Whoever goes elsewhere in the recording leaves the steps: there they were not taken.
    page.locator("#replay-position").focus()
    page.keyboard.press("Home")
    page.wait_for_function("window.brickpose.telemetry.filter.hand === null")
    ask(live, type="reset")
