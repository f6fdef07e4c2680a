"""Lenses in the files of other programs: read to the same pixels, or named as what they are."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.features.lab.chosen_lens import read_chosen_lens
from robot.camera import CameraError, Lens
from robot.lens_files.choosing import SeveralCamerasError
from robot.lens_files.reading import LensFile, read_lens_file
from robot.lens_files.writing import FORMATS

FISHEYE = np.array([[403.97646, -0.96635, 871.2187], [0, 404.70652, 597.37327], [0, 0, 1]])
"""As ROS's camera_calibration fits a wide lens: with a skew."""
BENDS = [0.175653, -0.031772, 0.000362, -0.000719]
PINHOLE = np.array([[461.6, 0, 362.6], [0, 460.3, 246.4], [0, 0, 1]])


def opened(folder: Path, text: str, name: str = "camera.yaml") -> LensFile:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_lens_file(path)


def listed(values: object) -> str:
    return ", ".join(repr(float(value)) for value in np.ravel(values))


def camera_info(model: str, matrix: np.ndarray = FISHEYE, bends: object = BENDS) -> str:
    return (
        "image_width: 1640\nimage_height: 1232\ncamera_name: csi\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{listed(matrix)}]\n{model}"
        f"distortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [{listed(bends)}]\n"
    )


def by_opencv(points: np.ndarray, matrix: np.ndarray, bends: object) -> np.ndarray:
    """Pixels of a fisheye by OpenCV, whose skew is a share of the focal length."""
    alpha = matrix[0, 1] / matrix[0, 0]
    pixels, _ = cv2.fisheye.projectPoints(
        points[:, None], np.zeros(3), np.zeros(3), matrix, np.array(bends), alpha=alpha
    )
    return np.asarray(pixels).reshape(-1, 2)


@pytest.mark.parametrize(
    "model",
    [
        "distortion_model: equidistant\n",
        "distortion_model: fisheye\n",
        "camera_model: fisheye\n",
        "distortion_model: ''\ncamera_model: fisheye\n",
        "distortion_model: Kannala_Brandt\n",
    ],
)
def test_the_skew_of_a_fisheye_is_carried(model: str, tmp_path: Path) -> None:
    file = opened(tmp_path, camera_info(model))
    assert (file.lens.model, file.remarks) == ("equidistant", ())
    points = np.random.default_rng(1).uniform([-2, -2, 0.6], [2, 2, 1.4], (400, 3))
    seen = file.lens.project(points)
    np.testing.assert_allclose(seen, by_opencv(points, FISHEYE, BENDS), atol=1e-8)
    straight = FISHEYE * [[1, 0, 1], [1, 1, 1], [1, 1, 1]]
    unskewed = Lens(1640, 1232, straight, np.array(BENDS), model="equidistant").project(points)
    assert 0.8 < np.abs(unskewed - seen).max() < 2  # what leaving the skew out would cost [px]
    back = file.lens.unproject(seen)
    np.testing.assert_allclose(back[:, :2], points[:, :2] / points[:, 2:], atol=1e-8)


MESSAGE = """header:
  stamp:
    sec: 1700000000
    nanosec: 5
  frame_id: camera
height: 480
width: 752
distortion_model: plumb_bob
{d}:
{bends}
{k}:
{matrix}
{r}: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
binning_x: 0
binning_y: 0
roi:
  x_offset: 0
  y_offset: 0
  height: 0
  width: 0
  do_rectify: false
---
"""
FIVE = [-0.29, 0.08, 0.0001, 1.7e-05, 0.01]


def message(ros: int, messages: int = 1) -> str:
    if ros == 1:
        parts = {"bends": f"  [{listed(FIVE)}]", "matrix": f"  [{listed(PINHOLE)}]"}
        return MESSAGE.format(d="D", k="K", r="R", **parts) * messages
    parts = {
        name: "\n".join(f"- {value!r}" for value in np.ravel(values).tolist())
        for name, values in (("bends", FIVE), ("matrix", PINHOLE))
    }
    return MESSAGE.format(d="d", k="k", r="r", **parts) * messages


@pytest.mark.parametrize(("ros", "messages"), [(1, 1), (2, 1), (2, 3), (1, 500)])
def test_what_topic_echo_prints_of_a_camera_is_read(
    ros: int, messages: int, tmp_path: Path
) -> None:
    text = message(ros, messages)
    file = opened(tmp_path, text if messages < 3 else text[:-40])  # Ctrl-C cuts the last one
    assert file.form == "a printed CameraInfo message"
    assert (file.lens.width, file.lens.height, file.lens.model) == (752, 480, "plumb_bob")
    np.testing.assert_array_equal(file.lens.matrix, PINHOLE)
    np.testing.assert_array_equal(file.lens.distortion, FIVE)


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("binning_x: 0", "binning_x: 2", "binning_x is '2'"),
        ("  x_offset: 0", "  x_offset: 8", "a part .roi."),
        (listed(PINHOLE), listed(np.zeros(9)), "was not calibrated"),
        ("distortion_model: plumb_bob", "distortion_model: fov", "field of view"),
    ],
)
def test_a_message_of_another_picture_is_refused(
    before: str, after: str, reason: str, tmp_path: Path
) -> None:
    with pytest.raises(CameraError, match=reason):
        opened(tmp_path, message(1).replace(before, after))


def camchain(model: str = "radtan", bends: object = FIVE[:4], camera: str = "pinhole") -> str:
    return (
        f"cam0:\n  cam_overlaps: []\n  camera_model: {camera}\n"
        f"  distortion_coeffs: [{listed(bends)}]\n  distortion_model: {model}\n"
        "  intrinsics: [461.6, 460.3, 362.6, 246.4]\n  resolution: [752, 480]\n"
        "  rostopic: /cam0/image_raw\n"
    )


@pytest.mark.parametrize(
    ("model", "bends", "name", "read"),
    [
        ("radtan", FIVE[:4], "plumb_bob", [*FIVE[:4], 0]),
        ("equidistant", BENDS, "equidistant", BENDS),
        ("none", [], "plumb_bob", [0] * 5),
    ],
)
def test_kalibrs_camchain_is_read(
    model: str, bends: list[float], name: str, read: list[float], tmp_path: Path
) -> None:
    file = opened(tmp_path, camchain(model, bends))
    assert (file.form, file.lens.model, file.lens.width) == ("Kalibr's camchain", name, 752)
    np.testing.assert_array_equal(file.lens.matrix, PINHOLE)
    np.testing.assert_array_equal(file.lens.distortion, read)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (camchain(camera="ds", model="none"), "double sphere.*valid are plumb_bob"),
        (camchain(camera="omni"), "unified camera"),
        (camchain(camera="eucm", model="none"), "extended unified"),
        (camchain("fov", [0.9]), "field of view.*equidistant"),
        (camchain().replace("[752, 480]", "[752]"), "resolution needs"),
        (camchain().replace("[461.6, ", "["), "intrinsics needs"),
        (camchain().replace("  resolution: [752, 480]\n", ""), "'resolution' is missing"),
    ],
)
def test_a_camchain_that_is_none_of_ours_is_named(text: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(CameraError, match=rf"camera\.yaml: .*{reason}"):
        opened(tmp_path, text)


PAIR = camchain() + camchain().replace("cam0", "cam1").replace("461.6", "460.6")


@pytest.mark.parametrize("name", ["cam1", "/cam1/image_raw", "cam1/image_raw"])
def test_of_a_camchain_of_several_cameras_one_is_chosen(name: str, tmp_path: Path) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(PAIR, encoding="utf-8")
    assert read_lens_file(path, name).lens.matrix[0, 0] == 460.6
    assert read_lens_file(path, "cam0").lens.matrix[0, 0] == 461.6


@pytest.mark.parametrize("name", ["", "cam2", "image_raw", "/"])
def test_which_cameras_a_camchain_has_is_said(name: str, tmp_path: Path) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(PAIR, encoding="utf-8")
    each = "cam0 (/cam0/image_raw, 752 x 480), cam1 (/cam1/image_raw, 752 x 480)"
    with pytest.raises(SeveralCamerasError, match=f"valid is one of {re.escape(each)}$") as told:
        read_lens_file(path, name)
    assert str(told.value).startswith(f"{path}: it ")
    path.write_text(camchain(), encoding="utf-8")
    assert name != "cam2" or "no camera 'cam2'" in str(told.value)


def test_other_files_have_no_names_of_cameras(tmp_path: Path) -> None:
    path = tmp_path / "camera.ini"
    path.write_text(INI, encoding="utf-8")
    with pytest.raises(CameraError, match=r"ROS's \.ini, of one camera without a name"):
        read_lens_file(path, "cam0")


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("answers", "chosen"), [("2\n", 460.6), ("cam1\n7\n1\n", 461.6)])
def test_at_a_terminal_the_camera_is_asked_for(
    answers: str, chosen: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(PAIR, encoding="utf-8")
    shown = Terminal()
    monkeypatch.setattr(sys, "stdin", Terminal(answers))
    monkeypatch.setattr(sys, "stdout", shown)
    assert read_chosen_lens(path, None).lens.matrix[0, 0] == chosen
    asked = shown.getvalue().splitlines()
    assert asked[0] == f"{path} describes several cameras: which one took the pictures?"
    assert asked[2] == "  2: cam1 (/cam1/image_raw, 752 x 480)"
    assert shown.getvalue().count("valid are 1 to 2") == answers.count("\n") - 1


@pytest.mark.parametrize(("terminal", "name"), [(True, None), (True, "cam7"), (False, None)])
def test_without_an_answer_it_is_said_how_to_choose(
    terminal: bool, name: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(PAIR, encoding="utf-8")
    monkeypatch.setattr(sys, "stdin", Terminal("\n") if terminal else io.StringIO())
    monkeypatch.setattr(sys, "stdout", Terminal())
    with pytest.raises(CameraError, match=r"cam1 \(.*\); --camera-name chooses"):
        read_chosen_lens(path, name)


@pytest.mark.parametrize("suffix", [".yaml", ".xml", ".json"])
@pytest.mark.parametrize("fisheye", [False, True])
def test_opencvs_file_storage_is_read(suffix: str, fisheye: bool, tmp_path: Path) -> None:
    path = tmp_path / f"camera{suffix}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("calibration_time", "Mon 3 Nov: 12:00")
    storage.write("image_width", 752)
    storage.write("image_height", 480)
    storage.write("flags", 0)
    if fisheye:
        storage.write("fisheye_model", 1)
    storage.write("camera_matrix", FISHEYE if fisheye else PINHOLE)
    storage.write("distortion_coefficients", np.array(BENDS if fisheye else FIVE)[:, None])
    storage.write("avg_reprojection_error", 0.25)
    storage.release()
    file = read_lens_file(path)
    assert (file.form, file.remarks) == ("OpenCV's FileStorage", ())
    assert (file.lens.width, file.lens.height) == (752, 480)
    assert file.lens.model == ("equidistant" if fisheye else "plumb_bob")
    np.testing.assert_array_equal(file.lens.matrix, FISHEYE if fisheye else PINHOLE)
    np.testing.assert_array_equal(file.lens.distortion, BENDS if fisheye else FIVE)


def storage_text(folder: Path, **entries: object) -> str:
    path = folder / "written.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, entry in entries.items():
        storage.write(name, entry)
    storage.release()
    return path.read_text()


def test_other_names_of_a_file_storage_are_known_and_a_missing_size_is_told(
    tmp_path: Path,
) -> None:
    text = storage_text(tmp_path, K=PINHOLE, D=np.array(FIVE))
    with pytest.raises(CameraError, match="size of the pictures: add lines image_width"):
        opened(tmp_path, text)
    file = opened(tmp_path, text + "image_width: 752\nimage_height: 480\n")
    np.testing.assert_array_equal(file.lens.distortion, FIVE)
    eyes = storage_text(tmp_path, M1=PINHOLE, D1=np.array(FIVE), M2=PINHOLE, D2=np.array(FIVE))
    with pytest.raises(CameraError, match="two cameras"):
        opened(tmp_path, eyes)


def test_four_numbers_without_a_model_are_read_with_a_word(tmp_path: Path) -> None:
    file = opened(tmp_path, camera_info("", PINHOLE, FIVE[:4]))
    assert file.lens.model == "plumb_bob"
    assert "4 coefficients and names no model" in file.remarks[0]
    assert "distortion_model: equidistant" in file.remarks[0]
    told = opened(tmp_path, camera_info("distortion_model: plumb_bob\n", PINHOLE, FIVE[:4]))
    assert told.remarks == ()
    np.testing.assert_array_equal(told.lens.distortion, [*FIVE[:4], 0])


@pytest.mark.parametrize(
    ("model", "bends", "name", "read"),
    [
        ("plumb_bob", [*FIVE, 0, 0, 0], "plumb_bob", FIVE),
        ("plumb_bob", [*FIVE, 0.1, 0.2, 0.3], "rational_polynomial", [*FIVE, 0.1, 0.2, 0.3]),
        ("rational_polynomial", FIVE, "rational_polynomial", [*FIVE, 0, 0, 0]),
        (
            "rational_polynomial",
            [*FIVE, 0.1, 0.2, 0.3, 0, 0, 0, 0, 0, 0],
            "rational_polynomial",
            [*FIVE, 0.1, 0.2, 0.3],
        ),
        ("plumb_bob", [], "plumb_bob", [0] * 5),
        ("equidistant", [*BENDS, 0], "equidistant", BENDS),
    ],
)
def test_coefficients_mean_what_opencv_takes_them_for(
    model: str, bends: list[float], name: str, read: list[float], tmp_path: Path
) -> None:
    lens = opened(tmp_path, camera_info(f"distortion_model: {model}\n", PINHOLE, bends)).lens
    assert lens.model == name
    np.testing.assert_array_equal(lens.distortion, read)


INI = f"""# Camera intrinsics

[image]

width
752

height
480

[narrow_stereo]

camera matrix
461.60000 0.00000 362.60000
0.00000 460.30000 246.40000
0.00000 0.00000 1.00000

distortion
{listed(FIVE).replace(",", "")}

rectification
1.00000 0.00000 0.00000
0.00000 1.00000 0.00000
0.00000 0.00000 1.00000

projection
461.60000 0.00000 362.60000 0.00000
0.00000 460.30000 246.40000 0.00000
0.00000 0.00000 1.00000 0.00000
"""


@pytest.mark.parametrize("name", ["camera.ini", "ost.txt"])
def test_the_ini_of_ros_is_read(name: str, tmp_path: Path) -> None:
    file = opened(tmp_path, INI.replace("\n", "\r\n") if name == "ost.txt" else INI, name)
    assert (file.form, file.lens.width, file.lens.height) == ("ROS's .ini", 752, 480)
    np.testing.assert_array_equal(file.lens.matrix, PINHOLE)
    np.testing.assert_array_equal(file.lens.distortion, FIVE)


def test_an_ini_of_a_fisheye_or_of_two_cameras_or_cut_short_is_named(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match=r"fisheye lens\? .*\.yaml of the same calibration"):
        opened(tmp_path, INI.replace(" 0.01\n", "\n"), "ost.txt")
    with pytest.raises(CameraError, match="several cameras"):
        opened(tmp_path, INI + INI, "camera.ini")
    with pytest.raises(CameraError, match="'distortion' is missing"):
        opened(tmp_path, INI.split("distortion", maxsplit=1)[0], "camera.ini")


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"%YAML:1.0\nCamera.type: PinHole\nCamera.fx: 500.0\n", "ORB-SLAM"),
        (b"%YAML:1.0\n---\nmodel_type: MEI\nprojection_parameters:\n   gamma1: 1\n", "ORB|VINS"),
        (b"\x1f\x8b\x08\x00", "archive.*ost.yaml"),
        (b"<html></html>", "opencv_storage"),
        (b"<opencv_storage><a>", "no readable XML"),
        (b"colours: [1, 2]\n", "expected the keys.*Kalibr's camchain"),
        (json.dumps([1, 2]).encode(), "expected the keys"),
        (b'{"a": ', "no readable camera file"),
    ],
)
def test_other_files_are_named(data: bytes, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    path.write_bytes(data)
    with pytest.raises(CameraError, match=rf"camera\.yaml: .*{reason}"):
        read_lens_file(path)


LENSES = {
    "plumb_bob": Lens(640, 480, PINHOLE, np.array(FIVE)),
    "equidistant": Lens(640, 480, PINHOLE, np.array(BENDS), model="equidistant"),
    "rational_polynomial": Lens(
        640, 480, PINHOLE, np.array([*FIVE, 0.1, 1e-5, 0.3]), model="rational_polynomial"
    ),
}


@pytest.mark.parametrize("form", FORMATS)
def test_what_is_written_for_a_program_is_read_to_the_same_numbers(
    form: str, tmp_path: Path
) -> None:
    for model in FORMATS[form].models:
        lens = LENSES[model]
        file = opened(tmp_path, FORMATS[form].write(lens), "camera" + FORMATS[form].suffixes[0])
        assert (file.form, file.remarks) == (FORMATS[form].title, ())
        assert (file.lens.width, file.lens.height, file.lens.model) == (640, 480, model)
        np.testing.assert_array_equal(file.lens.matrix, lens.matrix)
        np.testing.assert_array_equal(file.lens.distortion, lens.distortion)


@pytest.mark.parametrize("model", LENSES)
def test_opencv_reads_what_is_written_for_it(model: str, tmp_path: Path) -> None:
    path = tmp_path / "camera.yml"
    path.write_text(FORMATS["opencv"].write(LENSES[model]))
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(storage.getNode("camera_matrix").mat(), PINHOLE)
    read = storage.getNode("distortion_coefficients").mat()
    np.testing.assert_array_equal(read.ravel(), LENSES[model].distortion)
    assert storage.getNode("fisheye_model").real() == (model == "equidistant")
    assert storage.getNode("image_width").real() == 640
