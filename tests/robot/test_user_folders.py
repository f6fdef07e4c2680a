"""The user's folders on each operating system."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from robot import user_folders

ROOT = Path("/given").absolute()
FOLDERS = {
    ("data", "linux"): "me/.local/share/brickpose",
    ("data", "darwin"): "me/Library/Application Support/BrickPose",
    ("data", "win32"): "me/AppData/Local/BrickPose",
    ("state", "linux"): "me/.local/state/brickpose",
    ("state", "darwin"): "me/Library/Application Support/BrickPose",
    ("state", "win32"): "me/AppData/Local/BrickPose",
    ("cache", "linux"): "me/.cache/brickpose",
    ("cache", "darwin"): "me/Library/Caches/BrickPose",
    ("cache", "win32"): "me/AppData/Local/BrickPose",
}


@pytest.mark.parametrize(("kind", "platform"), FOLDERS)
def test_each_system_has_its_folders(
    kind: str, platform: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(Path, "home", lambda: Path("me"))
    folder = getattr(user_folders, f"{kind}_folder")
    assert folder({}) == Path(FOLDERS[kind, platform])
    variable = f"XDG_{kind.upper()}_HOME"
    assert folder({variable: "not/absolute"}) == Path(FOLDERS[kind, platform])
    assert folder({variable: str(ROOT)}) == ROOT / "brickpose", "who sets it, means it"


def test_windows_own_variable_names_the_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    given = {"LOCALAPPDATA": str(ROOT / "Local")}
    for folder in (user_folders.data_folder, user_folders.state_folder, user_folders.cache_folder):
        assert folder(given) == ROOT / "Local" / "BrickPose"
