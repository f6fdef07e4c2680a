"""What a check finds: a line of the doctor's report."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, PROBLEM = "ok", "warning", "problem"


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    level: str
    """``ok``; ``warning``: it works, but could be better; ``problem``: it does not work."""
    message: str
    """What the check found."""
    cure: str = ""
    """What to do, if ``message`` does not already say it."""

    def __str__(self) -> str:
        line = f"{self.level:<8} {self.message}"
        return f"{line}. Cure: {self.cure}" if self.cure else line


def ok(message: str) -> Finding:
    """Return a finding that all is well."""
    return Finding(OK, message)


def warning(message: str, cure: str = "") -> Finding:
    """Return a finding that something works but should be better."""
    return Finding(WARNING, message, cure)


def problem(message: str, cure: str = "") -> Finding:
    """Return a finding that something does not work."""
    return Finding(PROBLEM, message, cure)


def sentence(text: str) -> str:
    """Return a text with its first letter in upper case."""
    return text[:1].upper() + text[1:]
