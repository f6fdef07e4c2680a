"""What hypothesis tries depends on the file of a test alone."""

import sys
from importlib import import_module

from hypothesis import given, settings
from hypothesis import strategies as st
from same_examples import constants_of

from robot.errors import LONGEST

LOADED = 918_273_645


def tried() -> set[int]:
    seen = set()

    @settings(max_examples=300, database=None)
    @given(st.integers(0, 2**30))
    def see(number):
        seen.add(number)

    see()
    return seen


def test_modules_that_are_loaded_meanwhile_change_nothing(tmp_path, monkeypatch):
    before = tried()
    (tmp_path / "loaded_meanwhile.py").write_text(f"NUMBER = {LOADED}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert import_module("loaded_meanwhile").NUMBER == LOADED
    try:
        assert tried() == before
    finally:
        del sys.modules["loaded_meanwhile"]


def test_constants_of_what_the_file_imports_are_tried():
    assert LONGEST in constants_of(sys.modules[__name__]).integers
    assert LONGEST in tried()
