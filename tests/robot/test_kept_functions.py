"""Kept machine code: loaded without the compiler, and still there for callers that are compiled."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FUNCTIONS = """
from robot.compiling import compiled
@compiled()
def inner(x):
    return x + 1
@compiled()
def outer(x):
    return 2 * inner(x)
"""
COMPILER = "numba.np.arraymath"
"""A module that only compiling needs."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where functions are, of which one is compiled and kept."""
    (tmp_path / "functions.py").write_text(FUNCTIONS)
    assert said(tmp_path, "functions.inner(1.0)") == "2.0"
    return tmp_path


def said(folder: Path, *expressions: str) -> str:
    """What another process says of the functions, with what this one has kept."""
    code = f"import sys, functions; print({', '.join(expressions)})"
    kept = {"NUMBA_CACHE_DIR": str(folder / "kept"), "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=os.environ | kept, check=True,
        capture_output=True, text=True, timeout=120,
    ).stdout.strip()  # fmt: skip


def test_a_kept_function_is_called_without_the_compiler(folder: Path) -> None:
    uses = "sum(functions.inner.stats.cache_hits.values())", f"{COMPILER!r} in sys.modules"
    assert said(folder, "functions.inner(1.0)", *uses) == "2.0 1 False"
    assert said(folder, "functions.inner(1)", *uses) == "2 0 True"


def test_a_caller_is_compiled_with_a_function_that_was_kept(folder: Path) -> None:
    hits = [f"sum(functions.{name}.stats.cache_hits.values())" for name in ("inner", "outer")]
    both = "functions.inner(1.0)", "functions.outer(3.0)"
    assert said(folder, *both, *hits) == "2.0 8.0 1 0"
    assert said(folder, *both, *hits) == "2.0 8.0 1 1"
