"""The files that a bag consists of: those of its folder, unpacked if they are compressed."""

from __future__ import annotations

import re
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import yaml
import zstandard

from app.features.lab.localize.reading.sources import BagError
from app.features.recordings.files.file_kinds import MCAP, bag_ending, first_bytes, other_kind
from robot.file_names import as_written
from robot.yaml_file import parse_yaml

STORAGE = (".mcap", ".db3")
ENDINGS = (".bag", *STORAGE)
PACKED = ".zstd"
"""Further ending of a file that rosbag2 has compressed as a whole."""
ACTIVE = ".active"
"""Further ending of a ROS 1 bag that is being recorded."""
METADATA = "metadata.yaml"
BLOCK = 1 << 16


class BagFiles(NamedTuple):
    """The files of a bag."""

    paths: list[Path]
    remarks: list[str]
    """What is not as it should be, in words."""
    listed: bool
    """Whether the bag itself says which files it has."""


def is_bag_file(path: Path) -> bool:
    """Whether a file is a bag by its name or its first bytes."""
    return _unpacked_name(path).suffix in ENDINGS or bag_ending(path) is not None


def require_bag(path: Path) -> str:
    """Return the usual ending of what a file holds, as its first bytes say, or else its name.

    Raises:
        BagError: it is empty, or something else; says what.
    """
    ending = bag_ending(path)
    if ending is not None:
        return ending
    # MCAP's reader knows what else it may be; a recorder that was killed left all beside the file.
    if path.suffix == MCAP or path.with_name(f"{path.name}-wal").is_file():
        return path.suffix
    begin = first_bytes(path)
    held = other_kind(begin) or ("no bag by what it holds" if begin else "empty")
    raise BagError(f"{path} is {held}; valid is a bag that ros2 bag or rosbag has recorded")


def files_of(path: Path) -> BagFiles:
    """Return the files of a bag: the path itself, or those of a folder.

    Raises:
        BagError: there are none, or those of several bags; lists them.
    """
    if not path.exists():
        raise BagError(
            f"there is no {path}; valid is a .bag, .mcap or .db3 file, or a bag's folder"
        )
    if path.is_file():
        _require_bag_file(path)
        return BagFiles([path], [], listed=True)
    held = sorted((item for item in path.iterdir() if _is_storage(item)), key=_natural)
    names = _listed(path / METADATA)
    listed = [as_written(path / name) for name in names]
    present = [file for file in listed if file.is_file()]
    if present:
        missing = [file.name for file in listed if not file.is_file()]
        remarks = [f"{METADATA} lists {name}, which is missing" for name in missing]
        return BagFiles(present, remarks, listed=True)
    if not held:
        lists = f", but not {', '.join(names)}" if names else ""
        holds = f"has {METADATA}{lists}" if (path / METADATA).is_file() else f"has no {METADATA}"
        raise BagError(
            f"the folder {path} {holds}, and no {' or '.join(STORAGE)} file; valid is a ROS 2 "
            "bag's folder"
        )
    held = [item for item in held if item.suffix != PACKED or _unpacked_name(item) not in held]
    if len({(_prefix(item), _unpacked_name(item).suffix) for item in held}) > 1:
        raise BagError(several(path, held))
    remarks = [f"{METADATA} lists {', '.join(names)}; {held[0].name} is there"] if names else []
    return BagFiles(held, remarks, listed=False)


def several(folder: Path, files: list[Path]) -> str:
    """Say that the files of a folder are not those of one drive."""
    names = ", ".join(item.name for item in files)
    return (
        f"{folder} holds several drives; valid is one of its files: {names} (if they are one "
        "recording, `ros2 bag reindex` writes the metadata.yaml that says so)"
    )


def unpacked(path: Path, stack: ExitStack) -> tuple[Path, str | None]:
    """Return a file decompressed, until the stack is closed, and in words what is damaged of it.

    Raises:
        BagError: nothing of it can be decompressed.
    """
    if path.suffix != PACKED:
        return path, None
    folder = Path(stack.enter_context(TemporaryDirectory(prefix="brickpose")))
    result = folder / _unpacked_name(path).name
    size = 0
    with path.open("rb") as packed, result.open("wb") as plain:
        try:
            reader = zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True)
            while block := reader.read(BLOCK):
                size += plain.write(block)
        except zstandard.ZstdError as error:
            if not size:
                raise BagError(
                    f"{path} cannot be decompressed: {error}; valid is a file that `ros2 bag "
                    "record --compression-mode file` or zstd has written"
                ) from error
            return result, f"{path.name} is damaged or cut off after {size} decompressed bytes"
    return result, None


def _require_bag_file(path: Path) -> None:
    if path.suffix == ACTIVE:
        raise BagError(
            f"{path} is a recording that was not finished; `rosbag reindex {path.name}` mends it, "
            f"then rename it to {path.stem}"
        )
    if not is_bag_file(path):
        valid = ", ".join([*ENDINGS, *(f"{ending}{PACKED}" for ending in STORAGE)])
        held = other_kind(first_bytes(path)) or "no bag by its name"
        raise BagError(f"{path} is {held}; valid are {valid}")


def _unpacked_name(path: Path) -> Path:
    return path.with_suffix("") if path.suffix == PACKED else path


def _is_storage(path: Path) -> bool:
    hidden = path.name.startswith(".")  # as a Mac leaves them beside what it copies
    return _unpacked_name(path).suffix in STORAGE and path.is_file() and not hidden


def _listed(metadata: Path) -> list[str]:
    """Return the names of the files that a metadata.yaml lists; none if it cannot be read."""
    try:
        content: Any = parse_yaml(metadata.read_text(encoding="utf-8"))
        listed = content["rosbag2_bagfile_information"]["relative_file_paths"]
        return [Path(str(name)).name for name in listed]
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError):
        return []


def _prefix(path: Path) -> str:
    """Return a file's name without its number and endings."""
    return re.sub(r"_\d+$", "", _unpacked_name(path).stem)


def _natural(path: Path) -> list[tuple[int, str]]:
    """Return a sort key that puts part 10 after part 9."""
    stem = _unpacked_name(path).stem
    return [(int(part or 0), word) for word, part in re.findall(r"(\D*)(\d*)", stem)]
