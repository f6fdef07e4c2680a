"""What is read of logs that are damaged, or whose stamps tell nothing."""

import gzip
from pathlib import Path

import numpy as np
import pytest
import rooms
from hypothesis import given
from hypothesis import strategies as st

from app.features.lab.localize.reading.carmen import CarmenLog
from app.features.lab.localize.reading.pairing import Measurement
from app.features.lab.localize.reading.sources import BagError
from robot.geometry import Pose2


def written(path: Path, looks: int = 12) -> list[str]:
    """Write a log, and return its lines: two of a head, and two for each look."""
    _, steps, scans = rooms.lap(4, looks)
    rooms.write_log(path, steps, scans, Pose2())
    return path.read_text().splitlines()


def read(path: Path) -> tuple[list[list[Measurement]], list[str]]:
    log = CarmenLog(path)
    return [list(drive) for drive in log.drives()], log.remarks


def stamped(line: str, stamp: str) -> str:
    words = line.split()
    return " ".join([*words[:-3], stamp, "host", stamp])


def test_scans_whose_stamps_were_cut_keep_the_order_of_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "cut_stamps.log"
    lines = written(path)
    # As the log of CSAIL has them: 406 scans with two stamps.
    cut = [stamped(line, f"{1.13486e9 + 1e4 * (k > 13):g}") for k, line in enumerate(lines)]
    path.write_text("\n".join([*lines[:2], *cut[2:]]) + "\n")
    (drive,), remarks = read(path)
    assert len(drive) == 12
    assert (np.diff([measured.scan.stamp for measured in drive]) > 0).all()
    assert any("stamps do not rise: 10 of 12" in words for words in remarks)


def test_of_a_log_that_is_cut_off_the_whole_scans_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "whole.log"
    written(path)
    packed = gzip.compress(path.read_bytes())
    short = tmp_path / "short.log.gz"
    short.write_bytes(packed[: len(packed) // 2])
    (drive,), remarks = read(short)
    assert 3 <= len(drive) < 12
    assert any("cut off or damaged after line" in words for words in remarks)
    text = path.read_text()
    path.write_text(text[: int(0.7 * len(text))])
    (drive,), remarks = read(path)
    assert 3 <= len(drive) < 12


@pytest.mark.parametrize("lost", [1, 12, 25, 300])
def test_half_of_a_last_line_is_no_scan(tmp_path: Path, lost: int) -> None:
    path = tmp_path / "short.log"
    written(path)
    # Without one letter only a stamp that nobody reads is shorter; without more, one that is read.
    path.write_text(path.read_text()[: -1 - lost])
    (drive,), remarks = read(path)
    assert len(drive) == (12 if lost == 1 else 11)
    np.testing.assert_allclose(
        [measured.scan.stamp for measured in drive], 0.5 * np.arange(len(drive))
    )
    words = (
        "the file is cut off or damaged after line 25 (line 26 ends in its middle): the 11 scans"
    )
    assert remarks == ([] if lost == 1 else [f"{words} before it are used"])


@pytest.mark.parametrize(
    "odd",
    [
        "FLASER 180 1 2 3",
        "FLASER 180 " + "1.0 " * 181 + "0 0 0 0 0 0 3.0 host 3.0",
        "FLASER 180 " + "1.0 " * 179 + "0 0 0 0 0 0 3.0 host 3.0",
        "FLASER 1 1.0 0 0 0 0 0 0 nan host 3.0",
        "FLASER \xff",
    ],
)
def test_an_odd_line_costs_itself_alone(tmp_path: Path, odd: str) -> None:
    path = tmp_path / "odd.log"
    lines = written(path)
    path.write_bytes("\n".join([*lines[:10], odd, *lines[10:]]).encode("latin-1"))
    (drive,), remarks = read(path)
    assert len(drive) == 12
    assert remarks == ["broken lines that were left out: 1 (line 11: a broken FLASER message)"]


@pytest.mark.parametrize(
    ("shift", "place", "beams", "words"),
    [
        (-1e3, 2.0, 180, "its clock is"),
        (1e6, 0.0, 180, "days later"),
        (0.0, 50.0, 180, "cannot have driven"),
        (0.0, 0.0, 90, "a laser with 90 beams"),
        (0.0, 0.0, 180, None),
    ],
)
def test_another_drive_in_the_same_log_is_told(
    tmp_path: Path, shift: float, place: float, beams: int, words: str | None
) -> None:
    path = tmp_path / "both.log"
    begin = 1000.0

    def scan(k: int) -> str:
        later = k >= 8
        count = beams if later else 180
        x = 0.3 * k + place * later
        stamp = begin + 0.5 * k + shift * later
        return f"FLASER {count} {'2.0 ' * count}{x} 0 0 {x} 0 0 {stamp} host {stamp}"

    path.write_text("\n".join(scan(k) for k in range(16)) + "\n")
    drives, remarks = read(path)
    assert [len(drive) for drive in drives] == ([16] if words is None else [8, 8])
    assert all(words is not None and "line 9" in said and words in said for said in remarks)


def test_a_clock_that_is_set_back_while_the_robot_drives_on_begins_no_drive(tmp_path: Path) -> None:
    path = tmp_path / "set_back.log"
    poses = [(1.0 + 0.3 * k, 1000.0 + 0.5 * k - 3600.0 * (k >= 8)) for k in range(16)]
    path.write_text("".join(f"FLASER 2 2.0 2.0 {x} 0 0 {x} 0 0 {at!r} host 0\n" for x, at in poses))
    (drive,), remarks = read(path)
    stamps = [measured.scan.stamp for measured in drive]
    np.testing.assert_allclose(stamps, 1000.0 + 0.5 * np.arange(16))
    (words,) = remarks
    assert words.startswith("line 9: the clock was set back by 3600 s while the robot drove on")


def test_a_log_with_cut_stamps_ends_where_another_begins(tmp_path: Path) -> None:
    path = tmp_path / "both.log"
    stamps = [1.13486e9] * 8 + [0.5 * k for k in range(8)]
    path.write_text("".join(f"FLASER 2 2.0 2.0 0 0 0 0 0 0 {at!r} host 0\n" for at in stamps))
    drives, remarks = read(path)
    assert [len(drive) for drive in drives] == [8, 8]
    assert any("line 9: another drive begins, as its clock" in words for words in remarks)


@given(st.lists(st.integers(0, 10**9), min_size=1, max_size=30))
def test_whatever_stamps_a_drive_has_they_rise(tmp_path_factory, stamps: list[int]) -> None:
    path = tmp_path_factory.mktemp("logs") / "any.log"
    path.write_text("".join(f"FLASER 1 2.0 0 0 0 0 0 0 {at!r} host 0\n" for at in stamps))
    drives, _ = read(path)
    assert sum(len(drive) for drive in drives) == len(stamps)
    for drive in drives:
        assert (np.diff([measured.scan.stamp for measured in drive]) > 0).all()


def test_a_log_that_is_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BagError, match="cannot be read"):
        read(tmp_path / "none.log")
