"""Lenses in the files of DepthAI, COLMAP, mrcal and Metashape: the same pixels, or named."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from robot.camera import CameraError, Lens
from robot.lens_files.choosing import SeveralCamerasError
from robot.lens_files.reading import LensFile, read_lens_file

POINTS = np.random.default_rng(3).uniform([-0.4, -0.3, 0.8], [0.4, 0.3, 1.2], (200, 3))
K = np.array([[612.5, 0, 321.25], [0, 611.5, 238.75], [0, 0, 1]])
BROWN = [0.11, -0.24, 0.0012, -0.0007, 0.05]
RATIONAL = [*BROWN, 0.02, -0.03, 0.01]
FISHEYE = [0.05, -0.012, 0.003, -0.0004]


def opened(folder: Path, text: str | bytes, name: str, camera: str = "") -> LensFile:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_lens_file(path, camera)


def by_opencv(bends: list[float], matrix: np.ndarray = K) -> np.ndarray:
    still = np.zeros(3)
    pixels, _ = cv2.projectPoints(POINTS, still, still, matrix, np.array(bends))
    return np.asarray(pixels).reshape(-1, 2)


def by_opencv_fisheye(bends: list[float], matrix: np.ndarray = K) -> np.ndarray:
    still, points = np.zeros(3), POINTS[:, None]
    pixels, _ = cv2.fisheye.projectPoints(points, still, still, matrix, np.array(bends))
    return np.asarray(pixels).reshape(-1, 2)


def assert_sees(lens: Lens, pixels: np.ndarray) -> None:
    np.testing.assert_allclose(lens.project(POINTS), pixels, atol=1e-9)


# --- DepthAI -----------------------------------------------------------------------------------


def socket(kind: int, bends: list[float], **changed: object) -> dict[str, object]:
    camera = {
        "cameraType": kind,
        "distortionCoeff": bends + [0.0] * (14 - len(bends)),
        "extrinsics": {
            "rotationMatrix": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "specTranslation": {"x": 0.0, "y": 0.0, "z": 0.0},
            "toCameraSocket": -1,
            "translation": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
        "height": 480,
        "intrinsicMatrix": K.tolist(),
        "lensPosition": 0,
        "specHfovDeg": 0.0,
        "width": 640,
    }
    return camera | changed


def dump(*cameras: dict[str, object]) -> str:
    return json.dumps(
        {
            "batchName": "",
            "boardName": "OAK-D-LITE",
            "cameraData": [[number, camera] for number, camera in enumerate(cameras)],
            "imuExtrinsics": {},
            "stereoRectificationData": {},
            "version": 7,
        },
        indent=4,
    )


def test_a_dump_of_depthai_is_read(tmp_path: Path) -> None:
    file = opened(tmp_path, dump(socket(0, RATIONAL)), "oak.json")
    assert (file.form, file.remarks) == ("DepthAI's calibration", ())
    assert (file.lens.width, file.lens.height, file.lens.model) == (640, 480, "rational_polynomial")
    assert_sees(file.lens, by_opencv(RATIONAL))
    wide = opened(tmp_path, dump(socket(1, FISHEYE)), "oak.json").lens
    assert wide.model == "equidistant"
    assert_sees(wide, by_opencv_fisheye(FISHEYE))


def test_of_several_cameras_of_depthai_one_is_chosen(tmp_path: Path) -> None:
    none = socket(0, [], intrinsicMatrix=np.zeros((3, 3)).tolist())
    text = dump(socket(0, BROWN), socket(1, FISHEYE, width=1280, height=800), none)
    for name, model in (("CAM_A", "plumb_bob"), ("0", "plumb_bob"), ("CAM_B", "equidistant")):
        assert opened(tmp_path, text, "oak.json", name).lens.model == model
    for name in ("", "CAM_C", "CAM_H"):
        with pytest.raises(SeveralCamerasError, match=r"CAM_A \(640 x 480\), CAM_B \(1280 x 800"):
            opened(tmp_path, text, "oak.json", name)


@pytest.mark.parametrize(
    ("camera", "reason"),
    [
        (socket(2, []), "unrolled from a sphere.*calibrate lens"),
        (socket(3, []), "division"),
        (socket(7, []), "cameraType is '7'; valid are 0"),
        (socket(0, [*RATIONAL, 0.01]), "thin prism"),
        (socket(1, [*FISHEYE, 0.01]), "valid are 4"),
        (socket(0, [], intrinsicMatrix=[]), "no camera is calibrated"),
        (socket(0, [], intrinsicMatrix=[[1, 0], [0, 1]]), "intrinsicMatrix needs a list of 9"),
        (socket(0, [], distortionCoeff="none"), "distortionCoeff needs"),
        ({"intrinsicMatrix": K.tolist()}, "'cameraType' is missing"),
    ],
)
def test_a_dump_of_depthai_that_is_none_of_ours_is_named(
    camera: dict[str, object], reason: str, tmp_path: Path
) -> None:
    with pytest.raises(CameraError, match=rf"oak\.json: .*{reason}"):
        opened(tmp_path, dump(camera), "oak.json")


# --- COLMAP ------------------------------------------------------------------------------------

HEAD = (
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    "# Number of cameras: {count}\n"
)


def cameras_txt(*rows: str) -> str:
    return HEAD.format(count=len(rows)) + "\n".join(rows) + "\n"


def row(number: int, model: str, *values: float) -> str:
    return f"{number} {model} 640 480 " + " ".join(repr(float(value)) for value in values)


@pytest.mark.parametrize(
    ("model", "values", "bends"),
    [
        ("SIMPLE_PINHOLE", [600, 320, 240], [0, 0, 0, 0]),
        ("PINHOLE", [600, 601, 320, 240], [0, 0, 0, 0]),
        ("SIMPLE_RADIAL", [600, 320, 240, 0.1], [0.1, 0, 0, 0]),
        ("RADIAL", [600, 320, 240, 0.1, -0.2], [0.1, -0.2, 0, 0]),
        ("OPENCV", [600, 601, 320, 240, *BROWN[:4]], BROWN[:4]),
        ("FULL_OPENCV", [600, 601, 320, 240, *RATIONAL], RATIONAL),
        ("SIMPLE_RADIAL_FISHEYE", [600, 320, 240, 0.1], [0.1, 0, 0, 0]),
        ("RADIAL_FISHEYE", [600, 320, 240, 0.1, -0.02], [0.1, -0.02, 0, 0]),
        ("OPENCV_FISHEYE", [600, 601, 320, 240, *FISHEYE], FISHEYE),
    ],
)
def test_a_camera_of_colmap_is_read(
    model: str, values: list[float], bends: list[float], tmp_path: Path
) -> None:
    file = opened(tmp_path, cameras_txt(row(1, model, *values)), "cameras.txt")
    assert (file.form, file.remarks) == ("COLMAP's cameras.txt", ())
    fy = 601 if 601 in values else 600
    # COLMAP counts from the corner of the first pixel, OpenCV from its centre.
    k = np.array([[600, 0, 319.5], [0, fy, 239.5], [0, 0, 1]])
    seen = by_opencv_fisheye(bends, k) if "FISHEYE" in model else by_opencv(bends, k)
    assert_sees(file.lens, seen)


def test_of_several_cameras_of_colmap_one_is_chosen(tmp_path: Path) -> None:
    text = cameras_txt(row(1, "SIMPLE_PINHOLE", 600, 320, 240), row(7, "PINHOLE", 500, 5, 3, 2))
    assert opened(tmp_path, text, "cameras.txt", "1").lens.matrix[0, 0] == 600
    assert opened(tmp_path, text, "cameras.txt", "7").lens.matrix[0, 0] == 500
    with pytest.raises(SeveralCamerasError, match=r"1 \(SIMPLE_PINHOLE, 640 x 480\), 7 \(PINH"):
        opened(tmp_path, text, "cameras.txt")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (row(1, "FOV", 1, 1, 1, 1, 0.9), "field of view.*--ImageReader.camera_model OPENCV"),
        (row(1, "THIN_PRISM_FISHEYE", *range(12)), "thin prism.*camera_model"),
        (row(1, "NEW_MODEL", 1, 2), "'NEW_MODEL'.*camera_model"),
        (row(1, "OPENCV", 600, 601, 320, 240), "4 parameters of OPENCV; valid are fx fy cx cy k1"),
        (row(1, "PINHOLE", 600, 601, 320, np.nan), "parameters of PINHOLE needs a list of finite"),
        (row(1, "PINHOLE", 1, 1, 1, 1) + "\nand so on", "'and so on' is no camera of COLMAP"),
    ],
)
def test_a_camera_of_colmap_that_is_none_of_ours_is_named(
    text: str, reason: str, tmp_path: Path
) -> None:
    with pytest.raises(CameraError, match=rf"cameras\.txt: .*{reason}"):
        opened(tmp_path, cameras_txt(text), "cameras.txt")


def test_the_binary_file_of_colmap_is_named(tmp_path: Path) -> None:
    data = struct.pack("<QIiQQ4d", 1, 1, 1, 640, 480, 600, 601, 320, 240)
    with pytest.raises(CameraError, match=r"cameras\.bin; valid is cameras\.txt.*model_converter"):
        opened(tmp_path, data, "cameras.bin")


# --- mrcal -------------------------------------------------------------------------------------


def cameramodel(model: str, values: list[float], inputs: bytes = b"") -> str:
    listed = " ".join(f"{value!r}," for value in values)
    rest = f"    'optimization_inputs': {inputs!r},\n\n" if inputs else ""
    return (
        "# generated on 2023-01-02 10:11:12 with mrcal-calibrate-cameras # all: {it's}\n"
        "{\n"
        f"    'lensmodel':  '{model}',\n\n"
        "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
        f"    'intrinsics': [ {listed}],\n\n"
        "    'valid_intrinsics_region': [\n        [ 10, 20 ],\n        [ 600, 20 ],\n    ],\n\n"
        "    # extrinsics are rt_fromref\n"
        "    'extrinsics': [ 0., 0., 0., 0., 0., 0.],\n\n"
        "    'imagersize': [ 640, 480,],\n\n"
        "    'icam_intrinsics': 0,\n\n"
        "    # The optimization inputs contain all the data used to compute this model.\n"
        f"{rest}"
        "}\n"
    )


PLACE = [612.5, 611.5, 321.25, 238.75]
INPUTS = bytes(np.random.default_rng(1).choice(list(b"09azAZ!#$%&()*+-;<=>?@^_`{|}~"), 300_000))


@pytest.mark.parametrize("inputs", [b"", INPUTS[:900], INPUTS])
@pytest.mark.parametrize(
    ("model", "bends"),
    [
        ("LENSMODEL_PINHOLE", []),
        ("LENSMODEL_OPENCV4", BROWN[:4]),
        ("LENSMODEL_OPENCV5", BROWN),
        ("LENSMODEL_OPENCV8", RATIONAL),
        ("LENSMODEL_OPENCV12", [*RATIONAL, 0.0, 0.0, 0.0, 0.0]),
    ],
)
def test_a_cameramodel_of_mrcal_is_read(
    model: str, bends: list[float], inputs: bytes, tmp_path: Path
) -> None:
    file = opened(tmp_path, cameramodel(model, PLACE + bends, inputs), "camera-0.cameramodel")
    assert (file.form, file.remarks) == ("mrcal's cameramodel", ())
    assert (file.lens.width, file.lens.height) == (640, 480)
    assert_sees(file.lens, by_opencv(bends or [0.0] * 4))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            cameramodel("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=30_Ny=18_fov_x_deg=150", [1.0]),
            "'SPLINED_STEREOGRAPHIC' .mrcal's splines.*`mrcal-convert-lensmodel LENSMODEL_OPENCV8`",
        ),
        (cameramodel("LENSMODEL_CAHVOR", [1.0] * 9), "CAHVOR.*mrcal-convert-lensmodel"),
        (cameramodel("LENSMODEL_CAHVORE_linearity=0.37", [1.0] * 12), "'CAHVORE'"),
        (cameramodel("LENSMODEL_OPENCV12", [*PLACE, *RATIONAL, 0, 0, 0, 0.1]), "thin prism"),
        (cameramodel("LENSMODEL_OPENCV8", PLACE), "needs 12 finite numbers for LENSMODEL_OPENCV8"),
        (cameramodel("LENSMODEL_PINHOLE", PLACE).replace("640, 480", "640"), "imagersize needs"),
        (cameramodel("LENSMODEL_PINHOLE", PLACE).replace("'imager", "'other"), "'imagersize' is m"),
    ],
)
def test_a_cameramodel_that_is_none_of_ours_is_named(
    text: str, reason: str, tmp_path: Path
) -> None:
    with pytest.raises(CameraError, match=rf"a\.cameramodel: .*{reason}"):
        opened(tmp_path, text, "a.cameramodel")


# --- Metashape ---------------------------------------------------------------------------------


def calibration(projection: str = "frame", **values: float) -> str:
    entries = "".join(f"  <{key}>{value!r}</{key}>\n" for key, value in values.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<calibration>\n'
        f"  <projection>{projection}</projection>\n  <width>640</width>\n  <height>480</height>\n"
        f"{entries}  <date>2024-05-06T07:08:09Z</date>\n</calibration>\n"
    )


FRAME = {"f": 611.5, "cx": 1.5, "cy": -2.25, "b1": 1.0, "b2": -0.75, "k1": 0.11, "k2": -0.24,
         "k3": 0.05, "p1": -0.0007, "p2": 0.0012}  # fmt: skip


def by_the_manual(x: np.ndarray, y: np.ndarray, **values: float) -> np.ndarray:
    """Pixels, counted from the picture's corner, of x and y in the plane, or on the sphere."""
    given = dict.fromkeys(("cx", "cy", "b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2"), 0.0)
    given |= values
    r2 = x * x + y * y
    radial = 1 + sum(given[f"k{power}"] * r2**power for power in (1, 2, 3, 4))
    bent_x = x * radial + given["p1"] * (r2 + 2 * x * x) + 2 * given["p2"] * x * y
    bent_y = y * radial + given["p2"] * (r2 + 2 * y * y) + 2 * given["p1"] * x * y
    u = 320 + given["cx"] + bent_x * (given["f"] + given["b1"]) + bent_y * given["b2"]
    v = 240 + given["cy"] + bent_y * given["f"]
    return np.column_stack([u, v])


def test_a_calibration_of_metashape_is_read(tmp_path: Path) -> None:
    x, y = POINTS[:, 0] / POINTS[:, 2], POINTS[:, 1] / POINTS[:, 2]
    file = opened(tmp_path, calibration(**FRAME), "camera.xml")
    assert (file.form, file.remarks) == ("Metashape's calibration", ())
    assert (file.lens.width, file.lens.height, file.lens.model) == (640, 480, "plumb_bob")
    assert_sees(file.lens, by_the_manual(x, y, **FRAME) - 0.5)
    plain = opened(tmp_path, calibration(f=600.0, k4=0.0), "camera.xml").lens
    assert_sees(plain, by_the_manual(x, y, f=600.0) - 0.5)


@pytest.mark.parametrize("projection", ["fisheye", "equidistant_fisheye"])
def test_a_fisheye_of_metashape_is_read(projection: str, tmp_path: Path) -> None:
    x, y = POINTS[:, 0] / POINTS[:, 2], POINTS[:, 1] / POINTS[:, 2]
    r = np.hypot(x, y)
    values = {"f": 611.5, "cx": 1.5, "b1": 0.5, "k1": 0.05, "k2": -0.012, "k3": 0.003, "k4": -4e-4}
    lens = opened(tmp_path, calibration(projection, **values), "camera.xml").lens
    on_sphere = np.arctan(r) / r
    assert_sees(lens, by_the_manual(x * on_sphere, y * on_sphere, **values) - 0.5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (calibration(**FRAME, k4=0.001), "has k4, which no lens has here: save it .*OpenCV's"),
        (calibration(**FRAME, p3=0.001), "has p3"),
        (calibration("fisheye", f=600.0, p1=1e-4), "has p1"),
        (calibration("equisolid_fisheye", f=600.0), "a fisheye that keeps areas"),
        (calibration("spherical", f=600.0), "unrolled from a sphere"),
        (calibration(fx=600.0, fy=601.0, cx=320.0, cy=240.0), "old PhotoScan"),
        (calibration(cx=1.0), "'f' is missing"),
        (calibration(f=float("nan")), "f needs a list of finite"),
        (
            '<document version="2.0.0"><chunk label="a"><sensors/></chunk></document>',
            "exports of all cameras.*Camera Calibration, Adjusted, Save",
        ),
        ("<calibration><camera/></calibration>", "expected <opencv_storage>"),
        ("<!DOCTYPE a><calibration/>", "document type"),
    ],
)
def test_a_calibration_of_metashape_that_is_none_of_ours_is_named(
    text: str, reason: str, tmp_path: Path
) -> None:
    with pytest.raises(CameraError, match=rf"camera\.xml: .*{reason}"):
        opened(tmp_path, text, "camera.xml")


def test_a_zipped_project_is_an_archive(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="archive; valid is the file in it"):
        opened(tmp_path, b"PK\x03\x04" + bytes(40), "project.psz")
