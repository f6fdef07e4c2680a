"""One cause in words."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Cause:
    """A wrong thought in words; English, and templates for other languages."""

    symptom: str
    """What it does to the filter."""
    seems: str
    """What the code seems to do."""
    advice: str
    """What to look at next."""
