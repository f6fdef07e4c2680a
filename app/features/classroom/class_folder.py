"""ClassFolder: what lasts of a class: the students' folders, and the keys in their links."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.features.classroom.roster import TEACHER, Student
from app.files import atomic_file
from robot.errors import BrickPoseError

KEY_BYTES = 12
"""Random bytes of a link's key: 96 bits, nothing to guess at a hub's pace, and a small QR code."""


class ClassFolderError(BrickPoseError, OSError):
    """A class's folder cannot be used."""


@dataclass(frozen=True)
class ClassFolder:
    """The folder of one class, which only the user may read who starts it."""

    path: Path

    @property
    def homes(self) -> Path:
        """The folder with a folder for each student."""
        return self.path / "students"

    @property
    def config(self) -> Path:
        """JupyterHub's configuration."""
        return self.path / "jupyterhub_config.py"

    @property
    def names(self) -> Path:
        """The students' names by what the hub calls them, as JSON."""
        return self.path / "students.json"

    @property
    def links(self) -> Path:
        """The page to print."""
        return self.path / "links.html"

    @property
    def warm_socket(self) -> Path:
        """Where the warm parent of the students' servers listens."""
        return self.path / "warm.sock"

    def make(self) -> None:
        """Make what is not there yet.

        Raises:
            ClassFolderError: it cannot be made.
        """
        try:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            self.path.chmod(0o711 if os.geteuid() == 0 else 0o700)
            self.homes.mkdir(mode=0o711, exist_ok=True)
        except OSError as error:
            raise ClassFolderError(
                f"{self.path} cannot be made: {error.strerror}; another one is chosen by --folder"
            ) from error

    def home_of(self, login: str) -> Path:
        """Return the folder of a student."""
        return self.homes / login

    def keys(self, students: Sequence[Student]) -> dict[str, str]:
        """Return the keys of all links, the teacher's too; what is new is drawn and kept."""
        known = self.known_keys()
        logins = (TEACHER, *(student.login for student in students))
        keys = {login: known.get(login) or secrets.token_urlsafe(KEY_BYTES) for login in logins}
        # Who is not in the list today keeps the link for another day.
        self._write_keys(known | keys)
        return keys

    def known_keys(self) -> dict[str, str]:
        """Return all keys that are kept."""
        try:
            kept: dict[str, str] = json.loads((self.path / "keys.json").read_text("utf-8"))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise ClassFolderError(
                f"{self.path / 'keys.json'} cannot be read: {error}; remove it, and all links "
                "are new"
            ) from error
        return kept

    def proxy_token(self) -> str:
        """Return what hub and proxy know each other by; drawn at first, so that both may change."""
        path = self.path / "proxy_token"
        try:
            return path.read_text("ascii")
        except FileNotFoundError:
            token = secrets.token_hex(32)
            with atomic_file(path) as unfinished:
                unfinished.touch(mode=0o600)
                unfinished.write_text(token, encoding="ascii")
            return token

    def write_names(self, students: Sequence[Student]) -> None:
        """Keep the names for the wall."""
        with atomic_file(self.names) as unfinished:
            names = {student.login: student.name for student in students}
            unfinished.write_text(json.dumps(names, indent=1), encoding="utf-8")

    def _write_keys(self, keys: Mapping[str, str]) -> None:
        with atomic_file(self.path / "keys.json") as unfinished:
            unfinished.touch(mode=0o600)
            unfinished.write_text(json.dumps(keys, indent=1), encoding="utf-8")
