"""A robot built by hand is calibrated by the page's button: it drives, and its error falls."""

from __future__ import annotations

import tomllib

import httpx
import numpy as np
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import serving
from telemetry_drives import at_the_start, errors_of_a_drive

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server():
    options = ("--map", "square", "--robot", "sim", "--condition", "hand-built", "--seed", "531")
    with serving(*options) as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1280, height=720, view=False)


@pytest.mark.timeout(600)  # it drives, and adjusts behind all else that the computer does
def test_the_button_calibrates_and_the_error_falls(page, server):
    with server.live() as live:
        at_the_start(live)
        before = errors_of_a_drive(live, 4.0)
    page.locator("#calibration-open").click()
    state, drive = page.locator("#calibration-state"), page.locator("#calibration-drive")
    expect(state).to_contain_text("this robot has not been calibrated")
    drive.click()
    expect(page.locator("#robot-state")).to_have_text("calibrating")
    finish = page.locator("#calibration-finish")
    expect(finish).to_be_enabled(timeout=180_000)  # the drive takes 20 s of the robot's clock
    finish.click()
    expect(state).to_contain_text("s of driving on square", timeout=180_000)
    pitch = page.locator("#calibration-unknowns li", has_text="camera pitch")
    assert float(pitch.locator(".interval").inner_text().split()[1].rstrip("°")) < 0.2
    expect(page.locator("#calibration-meaning")).to_contain_text("the place is known to ±")
    with server.live() as live:
        at_the_start(live)
        after = errors_of_a_drive(live, 4.0)
    print(
        f"\nposition error: {1e3 * np.median(before):.1f} mm, then {1e3 * np.median(after):.2f} mm"
    )
    assert np.median(before) > 0.010
    assert np.median(after[len(after) // 4 :]) < 0.002
    profile = httpx.get(server.url + "/api/profile", timeout=20, trust_env=False)
    assert "attachment" in profile.headers["content-disposition"]
    assert abs(tomllib.loads(profile.text)["picture_delay"]["value"] - 0.04) < 0.01
    page.locator("#calibration-undo").click()
    expect(state).to_contain_text("this robot has not been calibrated")
    assert httpx.get(server.url + "/api/profile", timeout=20, trust_env=False).status_code == 404


def test_a_stop_ends_it_and_changes_nothing(page, server):
    page.locator("#calibration-open").click()
    page.locator("#calibration-drive").click()
    expect(page.locator("#robot-state")).to_have_text("calibrating")
    page.locator("#stop").click()
    expect(page.locator("#calibration-state")).to_contain_text("Nothing was changed")
    expect(page.locator("#robot-state")).to_have_text("stopped")
