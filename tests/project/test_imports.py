"""Which packages of others stay out of where; who of ours imports whom is in pyproject.toml."""

import ast
from pathlib import Path

import pytest
from places import ROOT

pytestmark = pytest.mark.slow

OURS = ("app", "benchmarks", "robot", "sim")


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield (node.module or "").split(".")[0]


def test_only_their_own_worlds_import_the_physics_engines():
    """MuJoCo's, ``sim/mujoco_world.py``, does so by name, when the first world is made."""
    users = {
        path.relative_to(ROOT).as_posix()
        for folder in OURS
        for path in (ROOT / folder).rglob("*.py")
        if {"pybullet", "mujoco"} & set(imported(path))
    }
    assert users == {"sim/bullet.py"}


def test_only_views_import_web_packages():
    for folder in ("robot", "sim"):
        for path in (ROOT / folder).rglob("*.py"):
            web = {"fastapi", "starlette", "uvicorn", "viser", "pydantic"} & set(imported(path))
            assert not web, f"{path.relative_to(ROOT)} imports {web}"


def test_the_packages_are_those_of_this_checkout():
    for name in OURS:
        module = __import__(name)
        assert Path(module.__file__).resolve().is_relative_to(ROOT), module.__file__
