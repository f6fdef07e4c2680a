"""The same drive with one parameter changed, beside the run before; in a real Chromium."""

from __future__ import annotations

import json
from collections.abc import Iterator
from urllib.request import urlopen

import pytest
from browsing import opened
from playwright.sync_api import Page, expect
from serving import ServedProgram, ask, serving, until

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server(tmp_path_factory) -> Iterator[ServedProgram]:
    folder = tmp_path_factory.mktemp("recordings")
    path = folder / "settings.toml"
    path.write_text(f"[recording]\nfolder = {json.dumps(str(folder))}\n", encoding="utf-8")
    with serving("--robot", "kinematic", "--map", "square", "--config", str(path)) as running:
        yield running


@pytest.fixture
def page(browser, server) -> Iterator[Page]:
    yield from opened(browser, server, width=1280, height=720, view=False)


def parameter(server: ServedProgram, name: str):
    with urlopen(f"{server.url}/api/parameters") as answer:
        return next(each["value"] for each in json.load(answer) if each["name"] == name)


def test_without_a_recording_it_is_said_what_to_do(server):
    with server.live() as live:
        assert "record, drive, and run it again" in ask(live, type="run_again")["message"]


def test_one_button_runs_the_drive_again_beside_the_run_before(page, server):
    again = page.get_by_role("button", name="run again")
    again.click()
    expect(page.locator("#toasts")).to_contain_text("From now on the drive is recorded")
    with server.live() as live:
        begun = until(live, lambda now: now["recording"] and now["recording"]["running"])["stamp"]
        page.locator("#figure-eight").click()
        until(live, lambda now: now["stamp"] > begun + 4)
        page.locator("#stop").click()
        before = until(live, lambda now: now["mode"] == "idle")
        count = 77
        assert (
            ask(
                live,
                type="set_parameters",
                values={"max_particles": 200, "min_particles": count, "filter": "particles"},
            )["type"]
            == "ack"
        )
        until(live, lambda now: now["filter"]["kind"] == "particles")
    again.click()
    expect(page.locator("#replay")).to_be_visible()
    # Both at once: at its end a replay begins again.
    late = "(window.brickpose.telemetry.replay?.position_s > 3.5) && window.brickpose.telemetry"
    now = page.wait_for_function(late, timeout=120_000).json_value()
    assert now["filter"]["kind"] == "particles" and parameter(server, "min_particles") == count
    # It is the drive from before, whose stamps count from the recording's beginning; what was
    # estimated then is told beside what is now.
    assert abs(now["stamp"] - now["replay"]["position_s"]) < 1
    assert now["stamp"] < before["stamp"] - begun + 1
    then = now["replay"]["estimate_then"]
    assert abs(then["x"] - now["truth"]["x"]) < 0.05
    assert then != {name: now["estimate"][name] for name in then}
    expect(page.locator("#plots-legend")).to_contain_text("error as recorded")
    # In the replay the same button begins anew, with what was changed by then.
    again.click()
    page.wait_for_function("window.brickpose.telemetry.replay?.position_s < 3")
    page.locator("#replay-end").click()
    expect(page.locator("#replay")).to_be_hidden()
