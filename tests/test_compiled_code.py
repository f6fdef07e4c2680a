"""Compiled code is made anew when any file changes that it was made from."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba  # noqa: F401 (there to be taken away)
import pytest

from robot import compiled_code
from robot.compiled_code import set_compile_cache

CALLER = "from numba import njit\nfrom robot.callee import f\n@njit\ndef g(): return f()\n"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package whose compiled function calls one of another file."""
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "caller.py").write_text(CALLER)
    (folder / "callee.py").write_text("def f(): return 1\n")
    (folder / "apart.py").write_text("x = 1\n")
    monkeypatch.setattr(compiled_code, "HERE", folder)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.delitem(sys.modules, "numba")
    return folder


def kept(package: Path) -> Path | None:
    os.environ["NUMBA_CACHE_DIR"] = str(package.parent / "kept")
    return set_compile_cache((package,))


@pytest.mark.parametrize(
    ("name", "other"), [("caller.py", True), ("callee.py", True), ("apart.py", False)]
)
def test_another_folder_is_used_once_what_it_is_made_of_changes(
    package: Path, name: str, other: bool
) -> None:
    before = kept(package)
    assert before == kept(package)
    with (package / name).open("a") as file:
        file.write("y = 2\n")
    assert (kept(package) != before) == other


def test_a_program_that_is_started_by_another_uses_the_same_folder(package: Path) -> None:
    first = set_compile_cache((package,))
    assert os.environ["NUMBA_CACHE_DIR"] == str(first)
    assert set_compile_cache((package,)) == first


def test_folders_of_long_ago_are_removed_and_others_kept(package: Path) -> None:
    old, recent = (package.parent / "kept" / f"compiled-{name}" for name in ("old", "recent"))
    old.mkdir(parents=True)
    recent.mkdir()
    os.utime(old, (1e9, 1e9))
    kept(package)
    assert not old.exists() and recent.exists()


def test_where_nothing_can_be_written_numba_decides(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (package.parent / "kept").write_text("a file where the folder should be")
    assert kept(package) is None


def test_a_compiled_function_sees_that_one_it_calls_has_changed(tmp_path: Path) -> None:
    """As after an update of the program."""
    folder = tmp_path / "robot"
    folder.mkdir()
    source = Path(compiled_code.__file__).read_text()
    (folder / "compiled_code.py").write_text(source)
    (folder / "__init__.py").write_text(
        "from robot.compiled_code import set_compile_cache\nset_compile_cache()\n"
    )
    cached = "from numba import njit\nfrom robot.callee import f\n@njit(cache=True)\n"
    (folder / "caller.py").write_text(cached + "def g(): return f()\n")
    for answer in (1, 2):
        (folder / "callee.py").write_text(
            f"from numba import njit\n@njit(cache=True)\ndef f(): return {answer}\n"
        )
        environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
        command = [sys.executable, "-c", "from robot.caller import g; print(g())"]
        ran = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
        )
        assert ran.stdout == f"{answer}\n"
