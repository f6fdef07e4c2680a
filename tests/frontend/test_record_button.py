"""The record button on the page, and recordings over the wire, with a server of its own."""

import json
import re

import httpx
import pytest
from browsing import opened
from playwright.sync_api import expect
from serving import ask, serving, until

from app.features.recordings.files.mcap_reader import open_recording

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("recordings")


@pytest.fixture(scope="module")
def server(folder, tmp_path_factory):
    config = tmp_path_factory.mktemp("config") / "recording.toml"
    config.write_text(f"[recording]\nfolder = {json.dumps(str(folder))}\n", encoding="utf-8")
    with serving("--robot", "kinematic", "--map", "stub", "--config", str(config)) as running:
        yield running


def is_running(now):
    return now["recording"] is not None and now["recording"]["running"]


def get(server, path):
    return httpx.get(server.url + path, timeout=20, trust_env=False)


def test_a_recording_is_made_by_commands(server, live, folder, tmp_path):
    assert ask(live, type="record", on=True, id=1)["type"] == "ack"
    again = ask(live, type="record", on=True)
    assert again["type"] == "error"
    assert "is being recorded; stop it first" in again["message"]
    now = until(live, lambda now: is_running(now) and now["recording"]["duration_s"] > 1)
    name = now["recording"]["file"]
    (entry,) = (one for one in get(server, "/api/recordings").json() if one["name"] == name)
    assert entry["unfinished"]
    so_far = get(server, f"/api/recordings/{name}").content
    (tmp_path / "so_far.mcap").write_bytes(so_far)
    assert open_recording(tmp_path / "so_far.mcap").unfinished
    assert ask(live, type="record", on=False)["type"] == "ack"
    done = until(live, lambda now: not is_running(now))["recording"]
    assert done["message"] is None
    reader = open_recording(folder / name)
    assert not reader.unfinished
    assert reader.duration == pytest.approx(done["duration_s"], abs=0.1)
    assert get(server, f"/api/recordings/{name}").content == reader.files[0].path.read_bytes()


def test_with_the_option_it_records_from_start_to_end(tmp_path):
    with (
        serving("--robot", "kinematic", "--map", "stub", "--record", str(tmp_path)) as server,
        server.live() as live,
    ):
        until(live, lambda now: now["recording"]["duration_s"] > 0.5)
    reader = open_recording(next(tmp_path.iterdir()))
    assert not reader.unfinished
    assert reader.duration > 0.5


@pytest.mark.browser
def test_the_button_records_and_links_to_the_file(server, browser):
    for page in opened(browser, server, width=1400, height=900, view=False):
        button = page.locator("#record")
        expect(button).to_have_text("Record")
        button.click()
        expect(button).to_contain_text(re.compile("Recording 0:0[1-9]"))
        expect(button).to_have_attribute("aria-pressed", "true")
        button.click()
        expect(button).to_have_text("Record")
        link = page.get_by_role("link", name="saved file")
        expect(link).to_be_visible()
        name = link.get_attribute("href").rsplit("/", 1)[1]
        answer = get(server, f"/api/recordings/{name}")
        assert answer.content.startswith(b"\x89MCAP0\r\n")


@pytest.mark.browser
def test_why_a_recording_ended_by_itself_is_said_once(server, browser):
    for page in opened(browser, server, width=1400, height=900, view=False):
        page.evaluate(
            """async () => {
                const { RecordButton } = await import("/static/features/recordings/record.js");
                const said = [];
                const toasts = { show: (text) => said.push(text) };
                const button = new RecordButton(async () => true, toasts);
                const ended = { file: "x", running: false, duration_s: 3, size_bytes: 1e6 };
                button.show({ ...ended, message: "The disk is full: it ended after 3 s." });
                button.show({ ...ended, message: "The disk is full: it ended after 3 s." });
                window.said = said;
            }"""
        )
        assert page.evaluate("window.said") == ["The disk is full: it ended after 3 s."]
