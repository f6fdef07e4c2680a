"""Recordings are listed and handed out over HTTP, and nothing else is."""

import errno
import os
import shutil
from pathlib import Path

import anyio
import httpx
import pytest
from fastapi import FastAPI
from recordings import make

from app.features.recordings import routes
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.library import annotate, find, listed, rename
from app.features.recordings.routes import recordings_router


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "secret.mcap").write_bytes(b"secret")
    parent = tmp_path / "recordings"
    for age, (name, close) in enumerate([("third", True), ("second", False), ("first", True)]):
        path = make(parent / name, ticks=100, close=close)
        os.utime(path, (2e9 - age, 2e9 - age))
    return parent


@pytest.fixture
def get(folder):
    return requests_to(recordings_router(lambda: folder))


def requests_to(router):
    app = FastAPI()
    app.include_router(router)

    async def ask(path, content=None, method=None):
        transport = httpx.ASGITransport(app)
        method = method or ("GET" if content is None else "PUT")
        async with httpx.AsyncClient(transport=transport, base_url="http://robot") as client:
            return await client.request(
                method, path, content=content, headers={"Content-Type": "application/json"}
            )

    return lambda *request: anyio.run(ask, *request)


@pytest.fixture
def put(get):
    return get


def test_all_are_listed_with_size_and_duration_newest_first(get, folder):
    found = get("/api/recordings").json()
    assert [one["name"] for one in found] == ["third", "second", "first"]
    assert [one["unfinished"] for one in found] == [False, True, False]
    for one in found:
        assert one["size_bytes"] == (folder / one["name"] / f"{one['name']}_0.mcap").stat().st_size
    assert found[0]["duration_s"] == pytest.approx(1.98)
    assert found[1]["duration_s"] is not None


@pytest.mark.parametrize("name", ["first", "second"])
def test_a_recording_comes_as_one_file(get, folder, name, tmp_path):
    answer = get(f"/api/recordings/{name}")
    assert answer.status_code == 200
    assert f'filename="{name}.mcap"' in answer.headers["content-disposition"]
    assert answer.content == (folder / name / f"{name}_0.mcap").read_bytes()
    (tmp_path / "got.mcap").write_bytes(answer.content)
    assert list(open_recording(tmp_path / "got.mcap").messages())


@pytest.mark.parametrize(
    "name",
    ["..", ".", "../secret.mcap", "..%2Fsecret.mcap", "%2e%2e%2fsecret.mcap",
     "first%2Ffirst_0.mcap", "first%00", "none", "link", "linked_file", "a" * 300, "f\u0456rst",
     "-rf", ".hidden"],
)  # fmt: skip
def test_no_name_leads_elsewhere(get, folder, name, tmp_path):
    make(folder / ".hidden", ticks=10)
    (folder / "link").symlink_to(folder / "first")
    (folder / "linked_file").mkdir()
    (folder / "linked_file" / "linked_file_0.mcap").symlink_to(tmp_path / "secret.mcap")
    answer = get(f"/api/recordings/{name}")
    assert answer.status_code in (404, 200)
    assert b"secret" not in answer.content.replace(b"secret.mcap", b"")
    if answer.status_code == 200:  # "." and ".." are gone before they are sent
        assert name in (".", "..")
        return
    with pytest.raises(RecordingError, match="valid are third, second, first"):
        find(folder, name)


def test_before_the_first_there_are_none(tmp_path):
    assert listed(tmp_path / "not_there") == []
    with pytest.raises(RecordingError, match="valid are none yet"):
        find(tmp_path / "not_there", "x")


@pytest.mark.parametrize(
    "text", ["", "[", "rosbag2_bagfile_information: 5", "x: {y: 1}", "a" * 2_000_000, "\x00"]
)
def test_without_metadata_of_use_the_file_tells_the_duration(folder, text):
    (folder / "first" / "metadata.yaml").write_text(text)
    assert find(folder, "first").duration_s == pytest.approx(1.98)
    assert find(folder, "first").size_bytes > 0
    (folder / "first" / "metadata.yaml").unlink()
    assert find(folder, "first").duration_s == pytest.approx(1.98)


@pytest.fixture
def full(monkeypatch):
    """A disk on which no file can be written any more."""

    def write_text(*_: object, **__: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    return lambda: monkeypatch.setattr(Path, "write_text", write_text)


def test_on_a_full_disk_a_recording_keeps_its_name_and_its_notes(folder, full):
    annotate(folder, "first", "along the wall")
    full()
    with pytest.raises(RecordingError, match="No space left"):
        annotate(folder, "first", "another")
    with pytest.raises(RecordingError, match="No space left"):
        rename(folder, "first", "other")
    kept = find(folder, "first")
    assert (kept.notes, kept.duration_s) == ("along the wall", pytest.approx(1.98))
    assert {item.name for item in listed(folder)} == {"first", "second", "third"}


def test_an_upload_is_whole_or_leaves_nothing(put, folder, monkeypatch):
    content = (folder / "first" / "first_0.mcap").read_bytes()
    before = sorted(folder.iterdir())
    assert put("/api/recordings/new", b"no recording").status_code == 409
    assert put("/api/recordings/first", content).status_code == 204, "it is there already"
    other = (folder / "second" / "second_0.mcap").read_bytes()
    assert put("/api/recordings/first", other).status_code == 409
    assert put("/api/recordings/..%2Fnew", content).status_code in (404, 409)
    monkeypatch.setattr(routes, "KEPT_FREE", 1 << 62)
    answer = put("/api/recordings/new", content)
    assert (answer.status_code, "disk is full" in answer.text) == (409, True)
    assert sorted(folder.iterdir()) == before
    monkeypatch.undo()
    assert put("/api/recordings/new", content).status_code == 204
    assert find(folder, "new").duration_s == pytest.approx(1.98)


def test_an_upload_to_a_folder_that_is_none_is_told_in_words(put, folder):
    shutil.rmtree(folder)
    folder.write_text("a file")
    answer = put("/api/recordings/new", b"")
    assert (answer.status_code, "nothing can be kept in" in answer.text) == (409, True)


@pytest.mark.parametrize("opened", ["first", "first/first_0.mcap"])
def test_what_is_open_stays_where_it_is(folder, opened):
    ask = requests_to(recordings_router(lambda: folder, folder / opened))
    for content, method in ((None, "DELETE"), ('{"name": "other"}', "PATCH")):
        answer = ask("/api/recordings/first", content, method)
        assert answer.status_code == 409
        assert answer.json()["detail"] == "first is open; go back to the robot first"
    assert ask("/api/recordings/third", None, "DELETE").status_code == 204
    assert [item["name"] for item in ask("/api/recordings").json()] == ["second", "first"]


def test_what_a_killed_upload_left_is_removed_by_the_next(put, folder):
    old, new = folder / ".new-old", folder / ".new-new"
    for left in (old, new):
        left.mkdir()
        (left / "new.mcap").write_bytes(b"half")
    os.utime(old, (1e9, 1e9))
    put("/api/recordings/text", b"no recording")
    assert not old.exists()
    assert new.exists()
