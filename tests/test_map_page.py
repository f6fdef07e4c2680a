"""The page maps the square by driving, saves it, and the robot goes on in it."""

from __future__ import annotations

import json

import httpx
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import pose_error, serving, until

from app.settings.config import MAPS
from robot.fields.field_loading import load_field

pytestmark = pytest.mark.browser
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
    page.locator("#mapping-name").fill("kitchen")
    page.locator("#mapping-use").click()
    expect(page.locator("#stat-field")).to_have_text("kitchen")
    expect(page.locator("#mapping")).to_be_hidden()
    assert load_field(str(folder / "kitchen.svg"), MAPS).tape_width == pytest.approx(0.05)
    with server.live() as live:
        errors = []

        def driven(now: dict) -> bool:
            # From where it stands: whether it fits is not asked.
            live.send(json.dumps({"type": "figure_eight"}))
            errors.append(pose_error(now))
            return now["mode"] == "figure_eight" and len(errors) > 60

        now = until(live, driven)
    assert now["map"] == "kitchen"
    assert max(errors) < 0.006
    page.locator("#mapping-open").click()
    expect(state).to_contain_text("Drive along all of the tape")
