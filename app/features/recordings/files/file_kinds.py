"""What a file is by its first bytes, whatever its name says."""

from __future__ import annotations

from pathlib import Path

from robot.lfs_pointer import LFS_POINTER

MCAP, SQLITE, ROS1_BAG = ".mcap", ".db3", ".bag"
BAGS = {b"\x89MCAP0\r\n": MCAP, b"SQLite format 3\0": SQLITE, b"#ROSBAG V2.0": ROS1_BAG}
"""First bytes of each kind of bag, with its usual ending."""

OTHERS = {
    b"#ROSBAG V1": "a bag of an early ROS 1 (rosbag fix makes it one of today)",
    b"#ROSBAG V": "a ROS 1 bag",
    b"SQLite format 3": "an SQLite database, as older ROS 2 bags are",
    b"\x28\xb5\x2f\xfd": "compressed as a whole by zstd (unzstd unpacks it)",
    b"\x1f\x8b": "compressed as a whole by gzip (gunzip or tar unpacks it)",
    b"BZh": "compressed as a whole by bzip2 (bunzip2 or tar unpacks it)",
    b"\xfd7zXZ": "compressed as a whole by xz (unxz or tar unpacks it)",
    b"PK\x03\x04": "a zip archive (unzip unpacks it)",
    b"PK\x05\x06": "a zip archive with nothing in it",
    b"Rar!": "a rar archive (unrar unpacks it)",
    b"7z\xbc\xaf\x27\x1c": "a 7z archive (7z unpacks it)",
    LFS_POINTER: "where Git LFS keeps the file, not the file (git lfs pull gets it)",
    b"<!DOCTYPE": "a web page, maybe of where the file can be fetched",
    b"<!doctype": "a web page, maybe of where the file can be fetched",
    b"<html": "a web page, maybe of where the file can be fetched",
}
"""First bytes of files that people mistake for recordings, and what these files are."""

LONGEST = max(map(len, (*BAGS, *OTHERS)))


def other_kind(begin: bytes) -> str | None:
    """Return what a file is that begins so, in words; None if that is not known."""
    return next((words for start, words in OTHERS.items() if begin.startswith(start)), None)


def bag_ending(path: Path) -> str | None:
    """Return the usual ending of what a file holds: ``.mcap``, ``.db3`` or ``.bag``.

    None if it is no bag by its first bytes, or cannot be read.
    """
    begin = first_bytes(path)
    return next((ending for start, ending in BAGS.items() if begin.startswith(start)), None)


def first_bytes(path: Path) -> bytes:
    """Return the bytes by which a file is known; none if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(LONGEST)
    except (OSError, ValueError):
        return b""
