"""What Git LFS leaves of a file that nobody fetched is named so, whatever was to be read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from app.features.lab.trajectories.reading import read_trajectory
from robot.errors import BrickPoseError
from robot.fields.field_loading import load_field
from robot.lens_files.reading import read_lens_file

POINTER = f"version https://git-lfs.github.com/spec/v1\noid sha256:{64 * 'e'}\nsize 4743512\n"


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("floor.svg", lambda path: load_field(str(path), path.parent)),
        ("floor.yaml", lambda path: load_field(str(path), path.parent)),
        ("camera.yaml", read_lens_file),
        ("calibration.json", read_lens_file),
        ("truth.csv", read_trajectory),
    ],
)
def test_a_pointer_is_named_with_its_cure(
    tmp_path: Path, name: str, read: Callable[[Path], object]
) -> None:
    path = tmp_path / name
    path.write_text(POINTER)
    with pytest.raises(BrickPoseError, match=r"Git LFS.*git lfs pull gets it"):
        read(path)


def test_so_is_that_of_a_maps_image(tmp_path: Path) -> None:
    (tmp_path / "floor.yaml").write_text(
        "image: floor.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    (tmp_path / "floor.pgm").write_text(POINTER)
    with pytest.raises(BrickPoseError, match="Git LFS"):
        load_field(str(tmp_path / "floor.yaml"), tmp_path)
