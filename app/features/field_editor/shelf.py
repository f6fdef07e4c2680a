"""The user's fields: drawings and ROS maps in a folder, taken in after they were read once."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import yaml

from app.files import atomic_file
from app.foreign_files import read_apart
from app.result_files import is_portable
from app.settings.config import MAPS
from app.settings.field_names import field_named, listed_fields
from robot.errors import BrickPoseError, CommandError
from robot.fields.drawing.question import LEFT_OUT
from robot.fields.drawing.svg_file import MAX_BYTES
from robot.fields.field_loading import load_field
from robot.fields.map_files import MAX_YAML_BYTES
from robot.yaml_file import parse_yaml

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}")
"""Valid names: none of them leads out of the folder, and each is one for drawn maps, too."""
LARGEST_DRAWING = MAX_BYTES
LARGEST_PICTURE = 32 << 20
"""Of a ROS map [bytes]: 100 m by 80 m at 16 mm, uncompressed."""
MOST = 500
"""Most files of a folder."""
PICTURE_KINDS = {
    **dict.fromkeys((b"P2", b"P3", b"P5", b"P6"), ".pgm"), b"\x89P": ".png", b"BM": ".bmp",
}  # fmt: skip
"""Endings of a map's picture by its first two bytes."""


class FieldFileError(BrickPoseError, ValueError):
    """A file cannot be kept as a field; the message says what is valid."""


@dataclass(frozen=True)
class ShelvedField:
    """A field that can be chosen, and its file if it has one."""

    name: str
    file: Path | None
    own: bool

    @property
    def is_drawing(self) -> bool:
        """Whether it is an SVG."""
        return self.file is not None and self.file.suffix == ".svg"

    @property
    def changed(self) -> float:
        """When its file was written [s since 1970]; 0 where there is none."""
        try:
            return 0.0 if self.file is None else self.file.stat().st_mtime
        except OSError:  # it was deleted meanwhile
            return 0.0


class FieldShelf:
    """The fields that a program can load, and the folder with the user's own."""

    def __init__(self, folder: Path) -> None:
        """Prepare to use a folder, which need not exist yet."""
        self.folder = folder

    def listed(self) -> list[ShelvedField]:
        """Return all fields, in the order in which the page lists their names."""
        return [self.find(name) for name in listed_fields(self.folder)]

    def find(self, name: str) -> ShelvedField:
        """Return a field by its name.

        Raises:
            CommandError: there is no such field; lists those that exist.
        """
        named = field_named(name, self.folder)
        path = Path(named)
        own = path.suffix != ""
        file = path if own else MAPS / f"{named}.svg"
        return ShelvedField(name, file if file.is_file() else None, own)

    def keep(self, name: str, content: bytes, *, yaml_bytes: int = 0, replace: bool = False) -> str:
        """Keep a drawing, or a ROS map, if the program can load it; return remarks, or nothing.

        Args:
            name: what it is called from now on.
            content: the drawing; or a map's YAML, and its picture behind it.
            yaml_bytes: how many bytes are the map's YAML; 0 if it is a drawing.
            replace: whether it may take the place of an own field of the name.

        Raises:
            FieldFileError: the name is invalid or taken, or nothing can be written.
            FieldError: the file is no field; one line says why.
            CostlyFileError: it takes too long to read.
        """
        self._require_name(name, replace=replace)
        try:
            if yaml_bytes:
                return self._keep_map(name, content[:yaml_bytes], content[yaml_bytes:])
            with atomic_file(self.folder / f"{name}.svg") as new:
                new.write_bytes(content)
                return read_apart(remarks_in, new)
        except OSError as error:
            why = error.strerror or str(error)
            raise FieldFileError(f"nothing can be kept in {self.folder}: {why}") from error
        except BrickPoseError as error:
            raise FieldFileError(_with_name(str(error), name)) from error

    def _require_name(self, name: str, *, replace: bool) -> None:
        if not NAME.fullmatch(name):
            raise FieldFileError(
                f"{name!r} is no name for a field; valid are 60 letters, digits, - and _"
            )
        if not is_portable(name):
            raise FieldFileError(f"Windows takes no file of the name {name}; choose another name")
        shelved: ShelvedField | None = None
        with suppress(CommandError):
            shelved = self.find(name)
        if shelved is not None and not (shelved.own and shelved.is_drawing and replace):
            raise FieldFileError(f"there is a field {name} already; choose another name")
        count = len([*self.folder.iterdir()]) if self.folder.is_dir() else 0
        if shelved is None and count >= MOST:
            raise FieldFileError(
                f"there are {MOST} files in {self.folder} already; delete some fields first"
            )

    def _keep_map(self, name: str, text: bytes, picture: bytes) -> str:
        kind = PICTURE_KINDS.get(picture[:2])
        if kind is None:
            raise FieldFileError("no picture of a known kind; valid are PGM, PPM, PNG and BMP")
        if len(text) > MAX_YAML_BYTES:
            raise FieldFileError(
                f"the map's YAML has {len(text)} bytes; valid are up to {MAX_YAML_BYTES}"
            )
        try:
            content = parse_yaml(text)
        except (yaml.YAMLError, UnicodeError, RecursionError, ValueError) as error:
            reason = str(getattr(error, "problem", None) or type(error).__name__)
            raise FieldFileError(f"no readable YAML: {reason}") from error
        if not isinstance(content, dict):
            raise FieldFileError("expected the keys of a map: image, resolution, origin, ...")
        content["image"] = f"{name}{kind}"  # wherever it was, it is beside the YAML now
        beside = self.folder / f"{name}{kind}"
        # The YAML last: without it the picture is nothing, and the name is still free.
        with atomic_file(beside) as image:
            image.write_bytes(picture)
        try:
            with atomic_file(self.folder / f"{name}.yaml") as new:
                new.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
                read_apart(remarks_in, new)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise
        return ""

    def delete(self, name: str) -> None:
        """Delete an own field, and a map's files of its name.

        Raises:
            CommandError: there is no such field.
            FieldFileError: it is not the user's, or cannot be deleted.
        """
        shelved = self.find(name)
        if not shelved.own or shelved.file is None:
            raise FieldFileError(f"{name} is a field of the program; valid are fields of your own")
        try:
            for ending in (".svg", ".yaml", *set(PICTURE_KINDS.values())):
                shelved.file.with_suffix(ending).unlink(missing_ok=True)
        except OSError as error:
            raise FieldFileError(f"{shelved.file} cannot be deleted: {error.strerror}") from error


def remarks_in(path: Path) -> str:
    """Return what of a file is no part of its field, in words; raises as ``load_field``."""
    return load_field(str(path), MAPS).notes.get(LEFT_OUT, "")


def _with_name(message: str, name: str) -> str:
    """Return a refusal without the path of the file that was tried."""
    return re.sub(r"^\S*\.unfinished-[0-9a-f]{32}\.(svg|yaml): ", f"{name}: ", message)
