"""Recordings are listed and handed out over HTTP, and nothing else is."""

import os

import anyio
import httpx
import pytest
from fastapi import FastAPI
from recordings import make

from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recorded import RecordingError
from app.recordings.library import find, listed
from app.recordings.routes import recordings_router


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
    app = FastAPI()
    app.include_router(recordings_router(lambda: folder))

    async def ask(path):
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://robot") as client:
            return await client.get(path)

    return lambda path: anyio.run(ask, path)


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
def test_without_metadata_of_use_the_duration_is_not_known(folder, text):
    (folder / "first" / "metadata.yaml").write_text(text)
    assert find(folder, "first").duration_s is None
    assert find(folder, "first").size_bytes > 0
    (folder / "first" / "metadata.yaml").unlink()
    assert find(folder, "first").duration_s is None
