"""What ``brickpose map`` says of a file that is no recording: the file is named, and no option."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from app.command_line import main

OUTS = ([], ["--out", "floor.yaml"], ["--out", "floor.svg"], ["--method", "grid"])


def said(recording: Path, options: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["map", str(recording), *options]) != 0
    told = capsys.readouterr().err.splitlines()[-1]
    assert "--" not in told
    assert str(recording) in told
    return told


@pytest.mark.parametrize("options", OUTS)
@pytest.mark.parametrize("name", ["drive.zip", "drive.mcap", "drive.bag", "drive.db3", "drive"])
def test_a_zip_file_is_named_and_what_unpacks_it(
    name: str,
    options: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with zipfile.ZipFile(tmp_path / name, "w") as archive:
        archive.writestr("drive/drive.mcap", b"\x89MCAP0\r\n")
    assert "is a zip archive (unzip unpacks it)" in said(tmp_path / name, options, capsys)


@pytest.mark.parametrize("options", OUTS)
@pytest.mark.parametrize(
    ("name", "begin", "told"),
    [
        ("drive.tar.gz", b"\x1f\x8b\x08\x00", "gzip"),
        ("drive.zip", b"PK\x05\x06" + bytes(18), "a zip archive with nothing in it"),
        ("drive.7z", b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
        ("drive.rar", b"Rar!\x1a\x07\x01\x00", "a rar archive"),
        ("drive.txt", b"a drive\n", "no bag by its name"),
    ],
)
def test_whatever_is_no_recording_is_named_before_any_option(
    name: str,
    begin: bytes,
    told: str,
    options: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(begin)
    assert told in said(tmp_path / name, options, capsys)


@pytest.mark.parametrize("name", ["nothing.mcap", "nothing.zip"])
def test_a_file_that_is_not_there_is_named(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "No such file" in said(tmp_path / name, [], capsys)


@pytest.mark.parametrize("options", OUTS)
def test_a_folder_without_a_bag_is_named(
    options: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive").mkdir()
    (tmp_path / "drive" / "drive.zip").write_bytes(b"PK\x03\x04")
    assert "no .mcap or .db3 file" in said(tmp_path / "drive", options, capsys)
