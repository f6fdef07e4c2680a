"""The list of recordings on the page: open, go back, describe, rename, delete, take in a file."""

import json
import shutil
from pathlib import Path
from urllib.request import urlopen

import pytest
from browsing import drop, drop_as_a_hand_does, opened
from playwright.sync_api import expect
from serving import ask, serving, until

from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay_command import recording_path

pytestmark = [pytest.mark.browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    path = folder / "settings.toml"
    path.write_text(f'[recording]\nfolder = "{folder}"\n')
    with serving("--robot", "kinematic", "--map", "square", "--config", str(path)) as running:
        with running.live() as live:
            ask(live, type="record", on=True)
            until(live, lambda now: now["recording"] and now["recording"]["duration_s"] > 2)
            ask(live, type="record", on=False)
            until(live, lambda now: not now["recording"]["running"])
        yield running


@pytest.fixture
def page(browser, server):
    yield from opened(browser, server, width=1100, height=760, view=False, locale="de-DE")


def names(server):
    with urlopen(f"{server.url}/api/recordings") as answer:
        return [entry["name"] for entry in json.load(answer)]


def test_a_recording_is_described_and_opened_and_the_robot_comes_back(page, server):
    page.get_by_role("button", name="Aufzeichnungen").click()
    row = page.locator("#recordings-items li").first
    expect(row.locator("img")).to_have_js_property("complete", True)
    assert row.locator("img").evaluate("image => image.naturalWidth") > 100
    row.get_by_label("Notizen").fill("Kurve links")
    row.get_by_label("Notizen").press("Enter")
    row.get_by_label("Name").fill("erste Fahrt")
    row.get_by_label("Name").press("Enter")
    expect(page.locator("#toasts")).to_contain_text("ist kein Name; gültig sind")
    row.get_by_label("Name").fill("fahrt-1")
    row.get_by_label("Name").press("Enter")
    expect(page.get_by_role("button", name="fahrt-1 löschen")).to_be_visible()
    expect(row.get_by_label("Notizen")).to_have_value("Kurve links")
    assert names(server) == ["fahrt-1"]
    row.get_by_role("button", name="öffnen").click()
    expect(page.locator("#replay")).to_be_visible()
    expect(page.locator("#robot-state")).to_have_text("Wiedergabe")
    page.get_by_role("button", name="Zurück zum Roboter").click()
    expect(page.locator("#replay")).to_be_hidden()
    expect(page.locator("#robot-state")).to_have_text("steht")


def test_a_dropped_file_is_taken_in_and_can_be_deleted(page, server, tmp_path):
    [known] = names(server)
    with urlopen(f"{server.url}/api/recordings/{known}") as answer:
        (tmp_path / "other_0.mcap").write_bytes(answer.read())
    (tmp_path / "text.mcap").write_text("no recording")
    page.get_by_role("button", name="Aufzeichnungen").click()
    page.set_input_files("#recordings-file", [tmp_path / "text.mcap", tmp_path / "other_0.mcap"])
    expect(page.locator("#recordings-items li")).to_have_count(2)
    expect(page.locator("#toasts")).to_contain_text("gültig ist eine MCAP-Datei")
    assert sorted(names(server)) == sorted([known, "other"])
    remove = page.get_by_role("button", name="other löschen")
    # What is listed stays while the list is read again, with a question that is open.
    kept = remove.element_handle()
    third = shutil.copy(tmp_path / "other_0.mcap", tmp_path / "third_0.mcap")
    page.set_input_files("#recordings-file", [third])
    expect(page.locator("#recordings-items li")).to_have_count(3)
    assert kept is not None and kept.evaluate("(one) => one.isConnected")
    for gone in ("other löschen", "third löschen"):
        remove = page.get_by_role("button", name=gone)
        remove.click()
        expect(remove).to_have_text("wirklich löschen?")
        remove.click()
        expect(remove).to_have_count(0)
    expect(page.locator("#recordings-items li")).to_have_count(1)
    assert names(server) == [known]


def test_a_replay_finds_what_the_page_recorded_by_its_name(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    folder = tmp_path / "brickpose" / "recordings"

    with pytest.raises(RecordingError, match=f"looked in .* in {folder}, which has none yet"):
        recording_path(Path("lost"))
    (folder / "kept").mkdir(parents=True)
    assert recording_path(Path("kept")) == folder / "kept"
    assert recording_path(Path("kept_0.mcap")) == folder / "kept"
    assert recording_path(tmp_path) == tmp_path


def test_a_parameter_is_typed_and_shown_with_the_languages_decimal_sign(page, server):
    field = page.locator("input[name=z_rand][type=text]")
    field.fill("0,25")
    field.press("Enter")
    expect(page.locator("[data-changed=true] input[name=z_rand][type=text]")).to_have_count(1)
    expect(field).to_have_value("0,25")
    page.reload()
    expect(field).to_have_value("0,25")
    with urlopen(f"{server.url}/api/parameters") as answer:
        values = {row["name"]: row["value"] for row in json.load(answer)}
    assert values["z_rand"] == 0.25


@pytest.fixture
def english(browser, server):
    yield from opened(browser, server, width=1366, height=768, view=False)


@pytest.fixture
def file(server, tmp_path):
    """A recording on the disk, as somebody sent it."""
    with urlopen(f"{server.url}/api/recordings/{names(server)[0]}") as answer:
        path = tmp_path / "lecture_0.mcap"
        path.write_bytes(answer.read())
    return path


@pytest.mark.parametrize("over", ["#map-canvas", "#camera-canvas", ".bar"])
def test_a_recording_that_is_dropped_on_the_page_plays(english, server, file, over):
    drop_as_a_hand_does(english, file, over=over)
    expect(english.locator("#replay")).to_be_visible()
    expect(english.locator("#robot-state")).to_have_text("replay")
    expect(english.locator(".drop-sign")).to_be_hidden()
    expect(english.locator("#recordings")).to_be_hidden()
    # Byte for byte the same, it is kept once.
    assert [name for name in names(server) if name.startswith("lecture")] == ["lecture"]
    english.get_by_role("button", name="Back to the robot").click()
    expect(english.locator("#replay")).to_be_hidden()


def test_another_recording_of_the_same_name_is_kept_beside_it(english, server, file):
    taken = file.rename(file.with_name("my drive, 1.mcap"))
    drop_as_a_hand_does(english, taken, over="#map-canvas")
    expect(english.locator("#replay")).to_be_visible()
    english.get_by_role("button", name="Back to the robot").click()
    expect(english.locator("#replay")).to_be_hidden()
    with server.live() as live:
        ask(live, type="record", on=True)
        until(live, lambda now: now["recording"] and now["recording"]["duration_s"] > 1)
        ask(live, type="record", on=False)
        until(live, lambda now: not now["recording"]["running"])
    newest = max(names(server), key=lambda name: name if name.startswith("brickpose_") else "")
    with urlopen(f"{server.url}/api/recordings/{newest}") as answer:
        taken.write_bytes(answer.read())
    drop_as_a_hand_does(english, taken, over="#map-canvas")
    expect(english.locator("#replay")).to_be_visible()
    assert {"my-drive-1", "my-drive-1-2"} <= set(names(server))
    english.get_by_role("button", name="Back to the robot").click()
    expect(english.locator("#replay")).to_be_hidden()


def test_several_recordings_are_listed_and_none_is_opened(english, server, file):
    other = file.with_name("homework.mcap")
    other.write_bytes(file.read_bytes())
    file = file.rename(file.with_name("first.mcap"))
    drop_as_a_hand_does(english, file, other, over="#map-canvas")
    for name in ("first", "homework"):
        expect(english.get_by_role("button", name=f"Delete {name}")).to_be_visible()
    expect(english.locator("#replay")).to_be_hidden()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("notes.mcap", b"no recording", "valid is an MCAP file"),
        ("empty.mcap", b"", "valid is an MCAP file"),
        ("talk.pptx", b"PK", "talk.pptx is no file that this page can open. Valid are"),
        ("noending", b"x", "noending is no file that this page can open. Valid are"),
        ("layout.json", b"{}", "no layout"),
    ],
)
def test_what_cannot_be_opened_is_told_with_what_can(english, server, file, name, content, words):
    before, there = names(server), file.with_name(name)
    there.write_bytes(content)
    drop_as_a_hand_does(english, there, over="#map-canvas")
    expect(english.locator("#toasts")).to_contain_text(words)
    expect(english.locator("#replay")).to_be_hidden()
    expect(english.locator(".drop-sign")).to_be_hidden()
    assert names(server) == before


def test_a_layout_that_is_dropped_is_taken(english):
    layout = {"kind": "brickpose-layout-1", "tree": "map"}
    drop(english, layout__json=json.dumps(layout))
    expect(english.locator("#camera")).to_be_hidden()
    expect(english.locator("#map")).to_be_visible()
