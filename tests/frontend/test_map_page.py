"""The page maps the square by driving, saves it, and the robot goes on in it."""

from __future__ import annotations

import json

import httpx
import numpy as np
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import pose_error, serving, until
from telemetry_drives import at_the_start, errors_of_a_drive

from app.settings.config import MAPS
from robot.fields.field_loading import load_field

pytestmark = [pytest.mark.browser, pytest.mark.slow]
SHORTEST_S = 10.0
"""Of the lap, the first circle and some of the second: all four sides have been in sight."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def server(folder):
    settings = folder / "settings.toml"
    settings.write_text(f'[mapping]\nfolder = "{folder}"\n')
    with serving("--map", "square", "--robot", "kinematic", "--config", str(settings)) as running:
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1280, height=720, view=False)


def doubted(route):
    answer = route.fetch()
    route.fulfill(response=answer, json={**answer.json(), "contradictory": True})


def test_the_square_is_mapped_saved_and_used(page, server, folder):
    page.locator("#mapping-open").click()
    state = page.locator("#mapping-state")
    expect(state).to_contain_text("Drive along all of the tape")
    page.locator("#mapping-start").click()
    page.locator("#figure-eight").click()
    page.wait_for_function(f"window.brickpose.telemetry.mapping?.seconds > {SHORTEST_S}")
    page.locator("#figure-eight").click()
    page.locator("#mapping-finish").click()
    expect(state).to_have_text("The map is done. Give it a name to save it.")
    expect(page.locator("#mapping-remarks")).to_contain_text("strokes of tape")
    drawn = httpx.get(server.url + "/api/mapping.svg", timeout=20, trust_env=False)
    assert "attachment" in drawn.headers["content-disposition"]
    expect(page.locator("#mapping-force")).to_be_hidden()
    page.locator("#mapping-name").fill("kitchen")
    page.locator("#mapping-use").click()
    expect(page.locator("#stat-field")).to_have_text("kitchen")
    expect(page.locator("#mapping")).to_be_hidden()
    assert load_field(str(folder / "kitchen.svg"), MAPS).tape_width == pytest.approx(0.05)
    with server.live() as live:
        now = until(live, lambda now: now["map"] == "kitchen" and now["estimate"] is not None)
        print(f"\nposition error where it stands: {1e3 * pose_error(now):.2f} mm")
        assert pose_error(now) < 0.006
        at_the_start(live)
        errors = errors_of_a_drive(live, 4.0)
    print(f"where it drives: {1e3 * np.median(errors[len(errors) // 4 :]):.2f} mm")
    assert np.median(errors[len(errors) // 4 :]) < 0.006
    page.locator("#mapping-open").click()
    expect(state).to_contain_text("Drive along all of the tape")


def test_a_map_that_contradicts_itself_is_saved_if_that_is_asked_for(page, folder):
    page.route("**/api/mapping", doubted)
    page.locator("#mapping-open").click()
    page.locator("#mapping-start").click()
    page.locator("#figure-eight").click()
    page.wait_for_function(f"window.brickpose.telemetry.mapping?.seconds > {SHORTEST_S}")
    page.locator("#figure-eight").click()
    page.locator("#mapping-finish").click()
    expect(page.locator("#mapping-state")).to_contain_text("The map is done")
    page.locator("#mapping-name").fill("doubted")
    page.get_by_label("Save it although it contradicts itself").check()
    page.locator("#mapping-keep").click()
    expect(page.locator("#mapping-state")).to_have_text("The map is saved as doubted.")
    (sent,) = [text for text in page.evaluate("window.told") if "save_map" in text]
    assert json.loads(sent)["force"] is True
    assert (folder / "doubted.svg").is_file()
    page.locator("#mapping-discard").click()
    expect(page.locator("#mapping-state")).to_contain_text("Drive along all of the tape")
    expect(page.locator("#mapping-discard")).to_be_hidden()
