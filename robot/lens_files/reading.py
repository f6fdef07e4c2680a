"""Reads the file of a lens, whichever program wrote it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import yaml

from robot.camera import CameraError, Lens
from robot.lens_files.choosing import SeveralCamerasError
from robot.lens_files.colmap import BINARY, colmap_lens, is_colmap, is_colmap_binary
from robot.lens_files.colmap import FORM as COLMAP
from robot.lens_files.depthai import FORM as DEPTHAI
from robot.lens_files.depthai import depthai_lens, is_depthai
from robot.lens_files.entries import number
from robot.lens_files.kalibr import FORM as KALIBR
from robot.lens_files.kalibr import cameras_of, kalibr_lens
from robot.lens_files.metashape import (
    PROJECT,
    is_metashape,
    is_metashape_project,
    metashape_lens,
)
from robot.lens_files.models import Described, lens_of
from robot.lens_files.mrcal import is_mrcal, mrcal_lens, without_pictures
from robot.lens_files.opencv import holds_matrices, opencv_lens, xml_entries
from robot.lens_files.ros import camera_info_lens, ini_lens, is_ini, is_message, message_lens
from robot.lfs_pointer import is_lfs_pointer
from robot.yaml_file import parse_yaml

LARGEST_BYTES = 64 << 10
"""Largest file: reading YAML takes seconds for each megabyte. Of printed messages, the first one
counts, and there may be more."""
FORMS = (
    "ROS's camera_info or its .ini, a printed CameraInfo message, Kalibr's camchain, OpenCV's "
    "FileStorage, DepthAI's calibration, COLMAP's cameras.txt, mrcal's .cameramodel, or "
    "Metashape's calibration in XML"
)
WITH_NAMES = (KALIBR, DEPTHAI, COLMAP)
"""Kinds of files that give each of their cameras a name."""


@dataclass(frozen=True)
class LensFile:
    """What a file says of a camera."""

    path: Path
    form: str
    """What kind of file it is, for people."""
    lens: Lens = field(repr=False)
    keys: Mapping[str, Any] = field(repr=False)
    """Its entries as text, for those that are BrickPose's own."""
    remarks: tuple[str, ...] = ()
    """What people should know of how it was read."""


def read_lens_file(path: Path, name: str = "") -> LensFile:
    """Read the lens of a file: ``FORMS`` says of which kinds.

    ``rolling_shutter_readout`` [s] is a key of BrickPose; other programs ignore it.

    Args:
        path: the file.
        name: of the camera or its topic, if the file may be a camchain of several.

    Raises:
        SeveralCamerasError: it is, and the name is none of them.
        CameraError: the file cannot be read, or a value is invalid; the message names it.
    """
    try:
        text = _text(path)
        described, keys = _described(text, name)
        lens, remarks = lens_of(described, number(keys.get("rolling_shutter_readout", "0")))
    except OSError as error:
        raise CameraError(f"{path}: no readable camera file: {error}") from error
    except KeyError as error:
        raise CameraError(f"{path}: the key {error} is missing") from error
    except SeveralCamerasError as error:
        raise SeveralCamerasError(f"{path}: {error}", error.cameras) from error
    except (ValueError, RecursionError, yaml.YAMLError) as error:
        raise CameraError(f"{path}: {error}") from error
    shown = (f"{path} is {described.form}: {remark}" for remark in remarks)
    return LensFile(path, described.form, lens, keys, tuple(shown))


def _text(path: Path) -> str:
    with path.open("rb") as file:
        data = without_pictures(file.read(LARGEST_BYTES + 1))
    if data[:2] == b"\x1f\x8b" or data[:4] == b"PK\x03\x04":
        raise CameraError("it is an archive; valid is the file in it (of ROS: ost.yaml)")
    if is_lfs_pointer(data):
        raise CameraError("it is where Git LFS keeps the file, not the file; git lfs pull gets it")
    if is_colmap_binary(data):
        raise CameraError(BINARY)
    if len(data) > LARGEST_BYTES:
        # Somebody let `ros2 topic echo` run: the first message ends at the first separator.
        first, separator, _ = data.partition(b"\n---")
        if not separator or b"distortion_model" not in first:
            raise CameraError(f"it is too large; valid are up to {LARGEST_BYTES} bytes")
        data = first
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CameraError(f"no readable camera file: {error}; valid are {FORMS}") from error


def _described(text: str, name: str) -> tuple[Described, dict[str, Any]]:
    """Return the lens of a text, and its entries."""
    described, entries = _by_form(text, name)
    if name and described.form not in WITH_NAMES:
        raise CameraError(f"it is {described.form}, of one camera without a name: no --camera-name")
    return described, entries


def _by_form(text: str, name: str) -> tuple[Described, dict[str, Any]]:
    if text.lstrip().startswith("<"):
        return _by_xml(_xml_root(text.strip()))
    lines = [line.partition("#")[0].strip() for line in text.splitlines()]
    if is_ini(lines):
        return ini_lens(lines), {}
    if is_colmap(lines):
        return colmap_lens(lines, name), {}
    if is_mrcal(text):
        return mrcal_lens(text), {}
    content = _entries(text)
    return _by_entries(content, name, opencv=text.startswith("%YAML:")), content


def _by_entries(content: dict[str, Any], name: str, *, opencv: bool) -> Described:
    if is_message(content) and not holds_matrices(content):
        return message_lens(content)
    if is_depthai(content):
        return depthai_lens(content, name)
    if cameras_of(content):
        return kalibr_lens(content, name)
    _refuse_settings_of_slam(content)
    if holds_matrices(content) or opencv:
        return opencv_lens(content)
    if not content.keys() & {"image_width", "camera_matrix", "distortion_coefficients"}:
        raise CameraError(f"expected the keys of a camera file; valid are {FORMS}")
    return camera_info_lens(content)


def _by_xml(root: ElementTree.Element) -> tuple[Described, dict[str, Any]]:
    if is_metashape(root):
        return metashape_lens(root), {}
    if is_metashape_project(root):
        raise CameraError(PROJECT)
    entries = xml_entries(root)
    return opencv_lens(entries), entries


def _xml_root(text: str) -> ElementTree.Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise CameraError("no readable XML: it has a document type or entity")
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise CameraError(f"no readable XML: {error}; valid are {FORMS}") from error


def _entries(text: str) -> dict[str, Any]:
    """Return the entries of YAML or JSON, all as text; of several printed messages, the first's."""
    try:
        if text.lstrip().startswith("{"):
            content = json.loads(text, parse_float=str, parse_int=str, parse_constant=str)
        else:
            documents = _documents(text)
            content = parse_yaml(documents[0])
            if len(documents) > 1 and not (isinstance(content, dict) and is_message(content)):
                raise CameraError(
                    f"no readable camera file: {len(documents)} documents, valid is one"
                )
    except CameraError:
        raise
    except (ValueError, RecursionError, yaml.YAMLError) as error:
        raise CameraError(f"no readable camera file: {error}; valid are {FORMS}") from error
    if not isinstance(content, dict):
        raise CameraError(f"expected the keys of a camera file; valid are {FORMS}")
    return {str(key): entry for key, entry in content.items()}


def _documents(text: str) -> list[str]:
    """Return the documents of YAML; one at least.

    OpenCV's first line, ``%YAML:1.0``, is none that YAML has, and is left out.
    """
    lines = text.splitlines()
    if lines and lines[0].startswith("%YAML"):
        lines[0] = ""
    documents = [""]
    for line in lines:
        if line.rstrip() == "---":
            documents.append("")
        elif line.strip():
            documents[-1] += line + "\n"
    return [document for document in documents if document] or [""]


def _refuse_settings_of_slam(content: dict[str, Any]) -> None:
    if any(key.startswith(("Camera.", "Camera1.")) for key in content):
        name = "ORB-SLAM's settings"
    elif "projection_parameters" in content:
        name = "camodocal's camera file (VINS)"
    else:
        return
    raise CameraError(f"it is {name}, of which no lens is read; valid are {FORMS}")
