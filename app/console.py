"""Lines for people."""

from __future__ import annotations

import sys


def say(text: str) -> None:
    """Write a line at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
