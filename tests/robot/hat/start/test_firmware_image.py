"""The firmware that the official library brings along."""

import importlib
import sys

import pytest

from robot.hat.start.firmware_image import (
    EXPECTED_VERSION,
    FirmwareImage,
    FirmwareImageError,
    checksum,
)


@pytest.mark.parametrize(
    ("data", "value"),
    [
        (b"", 1),
        (b"\0", 2),
        (b"123456789", 8757),
        (bytes(range(256)), 3426738657),
    ],
)
def test_the_checksum_is_the_bootloaders(data, value):
    assert checksum(data) == value


def test_the_installed_firmware_is_the_one_whose_language_is_spoken():
    image = FirmwareImage.installed()
    assert image.version == EXPECTED_VERSION == 1737564117
    assert (len(image.data), image.checksum, len(image.signature)) == (51456, 495305442, 64)


def test_the_library_is_not_run_for_it(monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "buildhat"]:
        monkeypatch.delitem(sys.modules, name)
    FirmwareImage.installed()
    assert "buildhat" not in sys.modules


@pytest.fixture
def package(tmp_path, monkeypatch):
    """An installed package whose firmware the test makes."""
    folder = tmp_path / "bricklib"
    (folder / "data").mkdir(parents=True)
    (folder / "__init__.py").write_text("raise RuntimeError('not to be run')", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()

    def make(version=str(EXPECTED_VERSION), data=b"abc", signature=b"s" * 64):
        (folder / "data" / "version").write_text(version, encoding="utf-8")
        (folder / "data" / "firmware.bin").write_bytes(data)
        (folder / "data" / "signature.bin").write_bytes(signature)
        return folder / "data"

    return make


def test_a_firmware_is_read_as_it_is(package):
    package(version=f"{EXPECTED_VERSION}\n")
    image = FirmwareImage.installed("bricklib")
    assert image == FirmwareImage(EXPECTED_VERSION, b"abc", b"s" * 64)


def test_a_library_that_is_not_installed_says_what_to_install():
    with pytest.raises(FirmwareImageError, match="pip install buildhat"):
        FirmwareImage.installed("no_such_library")


@pytest.mark.parametrize("missing", ["version", "firmware.bin", "signature.bin"])
def test_a_missing_file_is_named_with_the_cure(package, missing):
    (package() / missing).unlink()
    with pytest.raises(FirmwareImageError, match=f"{missing}.*pip install buildhat"):
        FirmwareImage.installed("bricklib")


@pytest.mark.parametrize(
    "wrong",
    [
        {"version": "1674818421"},
        {"version": "x"},
        {"data": b""},
        {"data": bytes(245_761)},
        {"signature": b"s" * 63},
    ],
)
def test_what_cannot_be_the_firmware_is_refused(package, wrong):
    package(**wrong)
    with pytest.raises(FirmwareImageError, match=r"pip install buildhat==0\.9\.0"):
        FirmwareImage.installed("bricklib")
