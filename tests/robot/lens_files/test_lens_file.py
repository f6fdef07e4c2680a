"""A ROS camera_info file is read whole, or refused with the reason."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml

from robot.camera import CameraError, Lens
from robot.description.spec import SPIKE
from robot.lens_files.reading import read_lens_file

YAML = (SPIKE.parent / "pi_camera.yaml").read_text(encoding="utf-8")


def read(folder: Path, text: str | bytes) -> Lens:
    path = folder / "lens.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_lens_file(path).lens


def changed(**values: object) -> str:
    """The good file with keys replaced; None removes one."""
    content = yaml.safe_load(YAML) | values
    return yaml.safe_dump({key: value for key, value in content.items() if value is not None})


def test_a_file_as_ros_writes_it_is_read(tmp_path: Path) -> None:
    lens = read(tmp_path, YAML)
    assert (lens.width, lens.height, lens.readout) == (640, 480, 0.015)
    np.testing.assert_array_equal(lens.matrix, [[530, 0, 319.5], [0, 530, 239.5], [0, 0, 1]])
    np.testing.assert_array_equal(lens.distortion, [0.16, -0.28, 0, 0, 0])


def test_without_a_readout_all_rows_are_exposed_at_once(tmp_path: Path) -> None:
    assert read(tmp_path, changed(rolling_shutter_readout=None)).readout == 0


@pytest.mark.parametrize(("model", "count"), [("rational_polynomial", 8), ("equidistant", 4)])
def test_a_file_of_a_wide_lens_is_read(model: str, count: int, tmp_path: Path) -> None:
    coefficients = {"data": [0.01 * place for place in range(count)]}
    lens = read(tmp_path, changed(distortion_model=model, distortion_coefficients=coefficients))
    assert lens.model == model
    np.testing.assert_array_equal(lens.distortion, coefficients["data"])


def test_numbers_may_have_an_exponent_without_a_point(tmp_path: Path) -> None:
    """YAML 1.1 calls 1e-3 a text, yaml-cpp a number."""
    text = YAML.replace("-0.28, 0.0, 0.0,", "-28e-2, 1e-3, 0,")
    np.testing.assert_allclose(read(tmp_path, text).distortion, [0.16, -0.28, 1e-3, 0, 0])


K = [530, 0, 319.5, 0, 530, 239.5, 0, 0, 1]
BROKEN = {
    "no width": (changed(image_width=None), "image_width.*missing"),
    "no matrix": (changed(camera_matrix=None), "camera_matrix.*missing"),
    "no coefficients": (changed(distortion_coefficients=None), "distortion_coefficients.*missing"),
    "width 0": (changed(image_width=0), "valid is 1 to 16384"),
    "width below 0": (changed(image_width=-640), "image_width.*whole number"),
    "huge": (changed(image_height=10**7), "valid is 1 to 16384"),
    "endless": (changed(image_height=10**300), "image_height"),
    "width inf": (changed(image_width=math.inf), "image_width.*whole number"),
    "half a pixel": (changed(image_width=640.5), "image_width.*whole number"),
    "width is a list": (changed(image_width=[640]), "image_width.*whole number"),
    "nan in the matrix": (changed(camera_matrix={"data": [math.nan, *K[1:]]}), "9 finite"),
    "inf in the matrix": (changed(camera_matrix={"data": [*K[:4], math.inf, *K[5:]]}), "9 finite"),
    "beyond floats": (changed(camera_matrix={"data": [10**400, *K[1:]]}), "9 finite"),
    "8 numbers": (changed(camera_matrix={"data": K[:8]}), "9 finite"),
    "10 numbers": (changed(camera_matrix={"data": [*K, 0]}), "9 finite"),
    "nested": (changed(camera_matrix={"data": [K[:3], K[3:6], K[6:]]}), "9 finite"),
    "no data": (changed(camera_matrix={"rows": 3}), "9 finite"),
    "flat": (changed(camera_matrix=K), "9 finite"),
    "words": (changed(camera_matrix={"data": ["f"] * 9}), "9 finite"),
    "focal length 0": (changed(camera_matrix={"data": [0, *K[1:]]}), "focal lengths"),
    "focal length below 0": (changed(camera_matrix={"data": [*K[:4], -530, *K[5:]]}), "focal"),
    "too much skew": (
        changed(camera_matrix={"data": [530, 54, *K[2:]]}),
        "54 px.*up to 0.1",
    ),
    "last row": (changed(camera_matrix={"data": [*K[:8], 0]}), "fx skew cx"),
    "6 coefficients": (changed(distortion_coefficients={"data": [0] * 6}), "4 or 5 of plumb_bob"),
    "nan of a coefficient": (changed(distortion_coefficients={"data": [0, 0, "x", 0]}), "finite"),
    "no such model": (changed(distortion_model="ds"), "double sphere.*plumb_bob .*equidistant"),
    "unknown model": (changed(distortion_model="unknown"), "'unknown'.*plumb_bob .*equidistant"),
    "fish eye of 3": (
        changed(distortion_model="fisheye", distortion_coefficients={"data": [0] * 3}),
        "3 coefficients.*k1 to k4",
    ),
    "thin prism": (
        changed(distortion_coefficients={"data": [0] * 8 + [0.1, 0, 0, 0]}),
        "thin prism",
    ),
    "model is a map": (changed(distortion_model={"a": 1}), "plumb_bob"),
    "readout below 0": (changed(rolling_shutter_readout=-0.01), "readout.*0 to 1"),
    "readout of 15": (changed(rolling_shutter_readout=15), "readout.*0 to 1"),
    "readout nan": (changed(rolling_shutter_readout=math.nan), "readout.*0 to 1"),
    "readout a word": (changed(rolling_shutter_readout="fast"), "readout.*0 to 1"),
    "empty": ("", "expected the keys"),
    "a word": ("lens", "expected the keys"),
    "a list": ("- 1\n- 2", "expected the keys"),
    "no YAML": ("a: [", "no readable"),
    "two documents": ("a: 1\n---\na: 2", "no readable"),
    "no text": (b"\xff\xfe\x00\x01", "no readable"),
    "deep": ("[" * 600, "no readable"),
    "python": ("!!python/object/apply:os.getcwd []", "expected the keys"),
    "impossible date": ("image_width: 2001-99-99", "image_width.*whole number"),
    "bad tag": ("image_width: !!bool x", "image_width.*whole number"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_file_is_refused_with_its_name_and_the_reason(case: str, tmp_path: Path) -> None:
    text, reason = BROKEN[case]
    with pytest.raises(CameraError, match=rf"lens\.yaml: (?s:.*){reason}") as refused:
        read(tmp_path, text)
    assert isinstance(refused.value, ValueError)
    assert len(str(refused.value)) < 600


def test_a_few_lines_that_stand_for_billions_of_values_are_refused(tmp_path: Path) -> None:
    lines = ["a0: &a0 [1,1,1,1,1,1,1,1,1]"]
    for level in range(1, 12):
        lines.append(f"a{level}: &a{level} [{','.join([f'*a{level - 1}'] * 9)}]")
    text = "\n".join([*lines, "image_width: *a11"])
    with pytest.raises(CameraError, match="image_width is list"):
        read(tmp_path, text)
    with pytest.raises(CameraError, match="camera_matrix needs"):
        read(tmp_path, "\n".join([*lines, "image_width: 9", "image_height: 9",
                                  "camera_matrix: {data: *a11}"]))  # fmt: skip


def test_a_huge_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="is too large; valid are up to 65536 bytes"):
        read(tmp_path, YAML + "#" * 1_000_000)


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "absent.yaml", tmp_path):
        with pytest.raises(CameraError, match="no readable"):
            read_lens_file(path)
