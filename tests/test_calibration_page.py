"""A robot built by hand is calibrated by the page's button: it drives, and its error falls."""

from __future__ import annotations

import json
import tomllib

import httpx
import numpy as np
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import pose_error, serving, until

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def server():
    options = ("--map", "square", "--robot", "sim", "--condition", "hand-built", "--seed", "531")
    with serving(*options) as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1280, height=720, view=False)


def errors_of_a_drive(live, seconds: float) -> np.ndarray:
    """Distances of the estimate from the truth while it drives arcs near the field's start [m]."""
    began, errors = None, []

    def driving(now: dict) -> bool:
        nonlocal began
        began = now["stamp"] if began is None else began
        forth = (now["stamp"] - began) % 4 < 2
        live.send(json.dumps({"type": "drive", "v": 0.1 if forth else -0.1, "omega": 0.6}))
        errors.append(pose_error(now))
        return now["stamp"] - began > seconds

    until(live, driving, 60)
    return np.array(errors)


def at_the_start(live) -> None:
    """Put the robot on the field's start, and tell the filter."""
    for kind in ("place", "set_pose"):
        live.send(json.dumps({"type": kind, "x": 0.0, "y": 0.0, "theta": 0.0}))


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
    expect(finish).to_be_enabled()
    finish.click()
    expect(state).to_contain_text("s of driving on square")
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
