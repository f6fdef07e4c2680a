"""Compiled code is made anew when any file changes that it was made from."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numba  # noqa: F401 (there to be taken away)
import pytest

from robot import compiled_code
from robot.compiled_code import set_compile_cache

CALLER = "from robot.callee import f\n@compiled()\ndef g(): return f()\n"

ROOT_ALONE = pytest.mark.skipif(os.getuid() != 0, reason="only root can give folders away")


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
    return set_compile_cache((package,)).folder


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
    assert os.environ["NUMBA_CACHE_DIR"] == str(first.folder)
    assert set_compile_cache((package,)) == first


def test_folders_of_long_ago_are_removed_and_others_kept(package: Path) -> None:
    old, recent = (package.parent / "kept" / f"compiled-{name}" for name in ("old", "recent"))
    old.mkdir(parents=True)
    recent.mkdir()
    os.utime(old, (1e9, 1e9))
    kept(package)
    assert not old.exists() and recent.exists()


@pytest.fixture
def user(package: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's own folder of caches, which does not exist yet; no other folder is given."""
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(package.parent / "user"))
    return package.parent / "user" / "brickpose"


def make_read_only(package: Path) -> None:
    """Root can write to every folder, but not into a file."""
    shutil.rmtree(package / "__pycache__", ignore_errors=True)
    (package / "__pycache__").write_text("")


def test_it_is_beside_the_program_if_that_can_be_written_to(package: Path, user: Path) -> None:
    folder = set_compile_cache((package,)).folder
    assert folder is not None and folder.parent == package / "__pycache__"
    assert not user.exists()


def test_of_a_read_only_installation_it_is_the_users(package: Path, user: Path) -> None:
    make_read_only(package)
    cache = set_compile_cache((package,))
    assert (cache.folder is not None and cache.folder.parent, cache.complaint) == (user, None)


def of_this_user(path: Path) -> None:
    pass


def of_another_user(path: Path) -> None:
    os.chown(path, 12345, 12345)


def of_a_group(path: Path) -> None:
    os.chown(path, -1, 12345)
    path.chmod(0o775)


@pytest.mark.parametrize(
    ("change", "used"),
    [
        (of_this_user, True),
        (lambda path: path.chmod(0o777), False),
        pytest.param(
            of_another_user, False, marks=pytest.mark.skipif(os.getuid() != 0, reason="needs root")
        ),
        pytest.param(
            of_a_group, False, marks=pytest.mark.skipif(os.getuid() != 0, reason="needs root")
        ),
    ],
)
@pytest.mark.parametrize("above", [False, True])
def test_code_that_others_can_have_written_is_not_used(
    package: Path, user: Path, change: Callable[[Path], None], used: bool, above: bool
) -> None:
    before = set_compile_cache((package,)).folder
    assert before is not None
    os.environ.pop("NUMBA_CACHE_DIR")
    change(before.parent if above else before)
    after = set_compile_cache((package,)).folder
    assert after is not None and after.parent == (before.parent if used else user)


def test_what_an_administrator_compiled_is_copied(package: Path, user: Path) -> None:
    """Into the user's folder, as numba reads only where it can write."""
    shared = package / "__pycache__"
    before = set_compile_cache((package,)).folder
    assert before is not None
    (before / "code.nbi").write_text("code")
    os.environ.pop("NUMBA_CACHE_DIR")

    def refuse(dir: Path) -> None:
        if shared in dir.parents:
            raise PermissionError(13, "Permission denied")
        return real(dir=dir)

    real = compiled_code.tempfile.TemporaryFile
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled_code.tempfile, "TemporaryFile", refuse)
        after = set_compile_cache((package,)).folder
    assert after is not None and after.parent == user
    assert (after / "code.nbi").read_text() == "code"
    assert [path.name for path in user.iterdir()] == [after.name]


def test_where_nothing_can_be_written_it_says_why(package: Path, user: Path) -> None:
    make_read_only(package)
    user.parent.write_text("a file where the folder should be")
    cache = set_compile_cache((package,))
    assert cache.folder is None
    assert cache.complaint is not None
    assert str(user) in cache.complaint and "cannot be written to" in cache.complaint


@pytest.mark.slow
def test_a_compiled_function_sees_that_one_it_calls_has_changed(tmp_path: Path) -> None:
    """As after an update of the program."""
    folder = tmp_path / "robot"
    folder.mkdir()
    for name in ("compiled_code.py", "compiling.py", "user_folders.py"):
        shutil.copy(Path(compiled_code.__file__).with_name(name), folder)
    (folder / "__init__.py").touch()
    own = "from robot.compiling import compiled\n"
    cached = f"{own}from robot.callee import f\n@compiled()\n"
    (folder / "caller.py").write_text(cached + "def g(): return f()\n")
    for answer in (1, 2):
        (folder / "callee.py").write_text(f"{own}@compiled()\ndef f(): return {answer}\n")
        environment = {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"}
        # Both states can be written within the second that Python's own cache tells apart.
        command = [sys.executable, "-B", "-c", "from robot.caller import g; print(g())"]
        ran = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
        )
        assert ran.stdout == f"{answer}\n"
