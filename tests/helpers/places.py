"""Where things are that tests use."""

from pathlib import Path

HELPERS = Path(__file__).resolve().parent
TESTS = HELPERS.parent
ROOT = TESTS.parent
MAPS = ROOT / "maps"
SHARED = ROOT.parent / "shared" / "data"
"""Recordings that are not part of this repository."""
