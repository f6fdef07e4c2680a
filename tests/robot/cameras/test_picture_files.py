"""Pictures of files are as they left the sensor, whatever EXIF says, and that is told."""

from __future__ import annotations

import logging
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from exif_pictures import tiff_header, with_exif

from robot.cameras.camera import PictureError
from robot.cameras.files import FolderPictures, VideoPictures
from robot.cameras.picture_files import pictures_in, read_picture

GREY = np.add.outer(np.arange(40) * 3, np.arange(60) * 2).astype(np.uint8)


def tiff(orientation: int, order: str = "II", kind: int = 4, *, big: bool = False) -> bytes:
    """The pixels as TIFF without compression; the tags are its own, and EXIF's."""

    def whole(value: int, size: int) -> bytes:
        return value.to_bytes(size, "little" if order == "II" else "big")

    place, wide = (16, 8) if big else (8, 4)
    tags = {256: 60, 257: 40, 258: 8, 259: 1, 262: 1, 273: place, 274: orientation, 277: 1,
            278: 40, 279: GREY.size}  # fmt: skip
    entries = b""
    for tag, value in tags.items():
        size = 2 if tag == 274 and kind == 3 else 4
        own = whole(3 if size == 2 else 4, 2) + whole(1, wide) + whole(value, size)
        entries += whole(tag, 2) + own + bytes(wide - size)
    end = place + GREY.size
    head = whole(43, 2) + whole(8, 2) + whole(0, 2) + whole(end, 8) if big else (
        whole(42, 2) + whole(end, 4))  # fmt: skip
    table = whole(len(tags), 8 if big else 2) + entries + bytes(wide)
    return order.encode() + head + GREY.tobytes() + table


def content(suffix: str, orientation: int, order: str = "II") -> bytes:
    """The same pixels with an orientation, as cameras write it into each kind of file."""
    parameters = {
        ".jpg": [cv2.IMWRITE_JPEG_QUALITY, 100],
        ".webp": [cv2.IMWRITE_WEBP_QUALITY, 101],
    }.get(suffix, [])
    data = cv2.imencode(suffix, GREY, parameters)[1].tobytes()
    exif = tiff_header(orientation, order)
    if suffix == ".jpg":
        # Something else stands before it, as in pictures of phones.
        other = b"\xff\xe0" + (18).to_bytes(2, "big") + b"JFIF" + bytes(12)
        body = b"Exif\0\0" + exif
        segment = b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body
        return data[:2] + other + segment + data[2:]
    if suffix == ".png":
        return with_exif(data, exif)
    if suffix == ".tif":
        return tiff(orientation)
    if suffix == ".webp":
        extended = b"VP8X" + (10).to_bytes(4, "little") + bytes([8, 0, 0, 0])
        extended += (59).to_bytes(3, "little") + (39).to_bytes(3, "little")
        padded = exif + bytes(len(exif) % 2)
        parts = extended + data[12:] + b"EXIF" + len(exif).to_bytes(4, "little") + padded
        return b"RIFF" + (len(parts) + 4).to_bytes(4, "little") + b"WEBP" + parts
    raise AssertionError(suffix)


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_no_picture_is_turned_and_those_that_ask_are_named(
    suffix: str, orientation: int, tmp_path: Path
) -> None:
    path = tmp_path / f"picture{suffix}"
    path.write_bytes(content(suffix, orientation))
    for flags in (cv2.IMREAD_GRAYSCALE, cv2.IMREAD_COLOR, cv2.IMREAD_ANYCOLOR):
        picture = read_picture(path, flags)
        pixels = picture.pixels if picture.pixels.ndim == 2 else picture.pixels[..., 1]
        assert pixels.shape == GREY.shape
        assert np.abs(pixels.astype(int) - GREY).max() <= 3
        assert picture.asks_to_be_turned == (orientation > 1)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("order", ["II", "MM"])
@pytest.mark.parametrize("kind", [3, 4])
@pytest.mark.parametrize("big", [False, True])
def test_no_kind_of_tiff_is_turned(
    big: bool, kind: int, order: str, orientation: int, tmp_path: Path
) -> None:
    path = tmp_path / "picture.tiff"
    path.write_bytes(tiff(orientation, order, kind, big=big))
    picture = read_picture(path, cv2.IMREAD_GRAYSCALE)
    np.testing.assert_array_equal(picture.pixels, GREY)
    assert picture.asks_to_be_turned == (orientation > 1)


def test_before_a_marker_of_a_jpeg_there_may_be_more_of_its_first_byte(tmp_path: Path) -> None:
    path, data = tmp_path / "picture.jpg", content(".jpg", 6)
    place = data.index(b"\xff\xe1")
    path.write_bytes(data[:place] + b"\xff\xff" + data[place:])
    assert read_picture(path).asks_to_be_turned


def test_the_order_of_bytes_may_be_either(tmp_path: Path) -> None:
    path = tmp_path / "picture.jpg"
    path.write_bytes(content(".jpg", 6, "MM"))
    assert read_picture(path).asks_to_be_turned


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".jpg", ".png", ".tif", ".webp"])
def test_damaged_files_are_pictures_or_refused(suffix: str, tmp_path: Path) -> None:
    rng, whole = np.random.default_rng(0), content(suffix, 3)
    path = tmp_path / f"picture{suffix}"
    read = 0
    for _ in range(150):
        data = bytearray(whole[: rng.integers(len(whole) + 1)] if rng.random() < 0.5 else whole)
        for place in rng.integers(0, max(len(data), 1), 3):
            if place < min(len(data), 200):
                data[place] = rng.integers(256)
        path.write_bytes(data)
        try:
            read_picture(path)
            read += 1
        except PictureError as error:
            assert str(path) in str(error)
    assert read > 0


def test_a_folder_as_a_camera_tells_it_one_time(tmp_path: Path, caplog) -> None:
    for number in range(3):
        (tmp_path / f"{number}.jpg").write_bytes(content(".jpg", 6))
    pictures = FolderPictures(tmp_path)
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert pictures.next(0).shape == GREY.shape
    (record,) = caplog.records
    assert "to be turned; pictures are taken as they left" in record.getMessage()


def test_a_folder_is_in_the_order_that_people_count_in(tmp_path: Path) -> None:
    names = ["2.png", "10.PNG", "a1b2.png", "a1b10.png", "a02.png", "a2.png", "frame (9).jpg",
             "frame (10).jpg"]  # fmt: skip
    for name in [*names, "._2.png", ".hidden.jpg", "notes.txt"]:
        (tmp_path / name).touch()
    assert [path.name for path in pictures_in(tmp_path)] == names


@pytest.mark.parametrize("quarter_turns", [1, 2, 3])
def test_a_video_that_asks_to_be_turned_is_taken_as_it_is(
    quarter_turns: int, tmp_path: Path, caplog
) -> None:
    path = tmp_path / "phone.mp4"
    height, width = picture_of_steps().shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10, (width, height))
    for _ in range(3):
        writer.write(picture_of_steps())
    writer.release()
    upright = VideoPictures(path).next(0)
    assert not caplog.records
    path.write_bytes(turned_video(path.read_bytes(), quarter_turns))
    turned = VideoPictures(path)
    for _ in range(5):  # beyond its end, where it is opened anew
        np.testing.assert_array_equal(turned.next(0), upright)
    turned.close()
    (record,) = caplog.records
    assert "to be turned; pictures are taken as they left" in record.getMessage()


def picture_of_steps() -> np.ndarray:
    """A picture that looks different each way up."""
    return cv2.cvtColor(np.kron([[0, 90, 180], [250, 40, 130]], np.ones((64, 64))).astype(np.uint8),
                        cv2.COLOR_GRAY2BGR)  # fmt: skip


def turned_video(mp4: bytes, quarter_turns: int) -> bytes:
    """As phones write it: the header of the track has a matrix in fixed point."""
    cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter_turns]
    one = 1 << 16
    matrix = [cosine * one, sine * one, 0, -sine * one, cosine * one, 0, 0, 0, 1 << 30]
    start = mp4.index(b"tkhd") + 4 + 40
    return mp4[:start] + struct.pack(">9i", *matrix) + mp4[start + 36 :]
