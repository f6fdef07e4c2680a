"""What a check found: one line for people."""

from __future__ import annotations

from dataclasses import dataclass

OK, WARNING, PROBLEM = "ok", "warning", "problem"


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report."""

    level: str
    """``ok``; ``warning``: it works, but; ``problem``: it does not work."""
    what: str
    """What was found."""
    cure: str = ""
    """What to do, where ``what`` does not say it already."""

    def __str__(self) -> str:
        line = f"{self.level:<8} {self.what}"
        return f"{line}. Cure: {self.cure}" if self.cure else line


def ok(what: str) -> Finding:
    """All is well."""
    return Finding(OK, what)


def warning(what: str, cure: str = "") -> Finding:
    """It works, but something should be better."""
    return Finding(WARNING, what, cure)


def problem(what: str, cure: str = "") -> Finding:
    """It does not work like this."""
    return Finding(PROBLEM, what, cure)


def sentence(text: str) -> str:
    """The same with a capital at its beginning."""
    return text[:1].upper() + text[1:]
