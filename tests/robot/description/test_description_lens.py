"""The lens beside a description: ours is read by the core, others' by what features add."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robot import hooks
from robot.camera import CameraError, Lens
from robot.description.lens_file import read_lens
from robot.description.spec import SPIKE
from robot.distortion import COEFFICIENTS
from robot.lens_files.camera_info import camera_info
from robot.lens_files.reading import read_lens_file
from robot.lens_files.writing import FORMATS

OURS = SPIKE.parent / "pi_camera.yaml"
YAML = OURS.read_text(encoding="utf-8")


@dataclass(frozen=True)
class Added:
    lens_files: tuple[Any, ...] = ()
    fields: tuple[()] = ()
    without: str = ""


@dataclass
class Asked:
    """A reader, and what it was asked for."""

    answer: Lens | CameraError
    paths: list[Path] = field(default_factory=list)

    def __call__(self, path: Path) -> Lens:
        self.paths.append(path)
        if isinstance(self.answer, CameraError):
            raise self.answer
        return self.answer


@pytest.fixture(autouse=True)
def put_back() -> Iterator[None]:
    """What features add is as it was, afterwards."""
    before = hooks._FIND[0]
    yield
    hooks.find_by(before)


def adding(*readers: Any, without: str = "") -> None:
    hooks.find_by(lambda: Added(readers, without=without))


def lens_of(model: str) -> Lens:
    rng = np.random.default_rng(7)
    k = np.array([[530.123456789, 0.25, 319.5], [0, 531.7, 1 / 3 + 239], [0, 0, 1]])
    bends = rng.normal(0, 0.01, len(COEFFICIENTS[model]))
    return Lens(640, 480, k, bends, readout=0.0123, model=model)


@pytest.mark.parametrize("model", COEFFICIENTS)
def test_what_we_write_is_read_without_a_feature_to_the_last_digit(
    model: str, tmp_path: Path
) -> None:
    adding()
    path, written = tmp_path / "lens.yaml", lens_of(model)
    path.write_text(camera_info(written, np.arange(4.0 + len(written.distortion)), "A\ntitle"))
    lens = read_lens(path)
    assert (lens.width, lens.height, lens.readout) == (640, 480, 0.0123)
    assert lens.model == model
    np.testing.assert_array_equal(lens.matrix, written.matrix)
    np.testing.assert_array_equal(lens.distortion, written.distortion)


def test_the_robots_own_lens_is_read_as_the_feature_reads_it() -> None:
    adding()
    ours, theirs = read_lens(OURS), read_lens_file(OURS).lens
    assert (ours.width, ours.height, ours.model) == (theirs.width, theirs.height, theirs.model)
    assert ours.readout == theirs.readout
    np.testing.assert_array_equal(ours.matrix, theirs.matrix)
    np.testing.assert_array_equal(ours.distortion, theirs.distortion)


OTHERS = {
    "opencv": FORMATS["opencv"].write(lens_of("equidistant")),
    "kalibr": FORMATS["kalibr"].write(lens_of("equidistant")),
    "no model": YAML.replace("distortion_model: plumb_bob\n", ""),
    "four coefficients": YAML.replace("-0.28, 0.0, 0.0, 0.0", "-0.28, 0.0, 0.0"),
    "another model": YAML.replace("plumb_bob", "fisheye"),
    "models": YAML.replace("plumb_bob", "[plumb_bob]"),
    "digits for numbers": YAML.replace("[0.16, -0.28, 0.0, 0.0, 0.0]", "12345"),
    "half a pixel": YAML.replace("640", "640.5"),
    "numbers within": YAML.replace("0.16,", "[0.16],"),
    "infinite": YAML.replace("0.16,", "inf,"),
    "a readout of a minute": YAML.replace("0.015", "60"),
    "too large": YAML + "#" * (64 << 10),
    "no table": "lens",
    "no YAML": "a: [",
    "nothing": "",
}


@pytest.mark.parametrize("case", OTHERS)
def test_any_other_file_is_for_the_readers_that_features_add(case: str, tmp_path: Path) -> None:
    (path := tmp_path / "lens.yaml").write_text(OTHERS[case])
    read = Asked(lens_of("plumb_bob"))
    adding(read)
    assert read_lens(path) is read.answer
    assert read.paths == [path]


@pytest.mark.parametrize("case", OTHERS)
def test_without_a_reader_it_is_refused_by_the_name_of_what_was_left_out(
    case: str, tmp_path: Path
) -> None:
    (path := tmp_path / "lens.yaml").write_text(OTHERS[case])
    adding(without="; without calibration")
    with pytest.raises(CameraError) as refused:
        read_lens(path)
    words = str(refused.value)
    assert words.startswith(f"{path}: ")
    assert words.endswith("equidistant; without calibration")
    assert "\n" not in words


def test_a_reader_that_refuses_leaves_the_file_to_the_next(tmp_path: Path) -> None:
    (path := tmp_path / "lens.bin").write_bytes(b"\xff\x00")
    first, second = Asked(CameraError("first")), Asked(CameraError("second"))
    third = Asked(lens_of("plumb_bob"))
    adding(first, second, third)
    assert read_lens(path) is third.answer
    adding(first, second)
    with pytest.raises(CameraError, match="first"):
        read_lens(path)


def test_ours_is_not_asked_of_others() -> None:
    read = Asked(CameraError("asked"))
    adding(read)
    assert read_lens(OURS).width == 640
    assert read.paths == []


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    adding()
    with pytest.raises(CameraError, match=r"absent\.yaml"):
        read_lens(tmp_path / "absent.yaml")
