"""``make`` takes the Python that it is asked for, and leaves an environment of the same alone."""

import os
import shutil
import subprocess
import sys

import pytest

from app.settings.config import ROOT

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
THIS = f"{sys.version_info[0]}.{sys.version_info[1]}"


def program(path, says):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{says}\n")
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def make(tmp_path):
    """Runs make where it has nothing to do; tells whether the environment is still there."""
    shutil.copy(ROOT / "Makefile", tmp_path)

    def make(have, *words, **environment):
        program(tmp_path / ".venv/bin/python", have)
        known = {name: text for name, text in os.environ.items() if name != "PYTHON"}
        done = subprocess.run(
            ["make", "Makefile", *words], cwd=tmp_path, env=known | environment, check=False,
            capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        return (tmp_path / ".venv").exists(), done.stdout + done.stderr

    return make


def test_another_python_gets_an_environment_of_its_own(make):
    kept, said = make("echo 3.10", PYTHON=sys.executable)
    assert not kept
    assert f"Making .venv anew for Python {THIS}: it was of 3.10" in said


def test_it_may_stand_behind_make_too(make):
    assert not make("echo 3.10", f"PYTHON={sys.executable}")[0]


def test_the_same_python_keeps_its_environment(make):
    assert make(f"echo {THIS}", PYTHON=sys.executable)[0]


def test_an_environment_is_kept_if_no_python_is_asked_for(make):
    assert make("echo 3.10")[0]


def test_an_environment_whose_python_is_gone_is_made_anew(make):
    kept, said = make("exit 1")
    assert not kept
    assert "a Python that is gone" in said


def test_nothing_is_removed_for_what_is_no_fitting_python(make, tmp_path):
    for other in ("python-that-is-nowhere", program(tmp_path / "old", "echo")):
        kept, said = make(f"echo {THIS}", PYTHON=other)
        assert kept
        assert f"{other} is no Python 3.11 or newer" in said


def test_a_dry_run_removes_nothing(make):
    assert make("echo 3.10", "-n", PYTHON=sys.executable)[0]
    assert make("echo 3.10", "-n", f"PYTHON={sys.executable}")[0]
