"""The grader's findings: each has a cause, a symptom, the smallest case and the next step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlencode

from app.features.course.grader.drawing import translated
from app.features.course.grader.words import ENGLISH_TEXTS, Words
from app.languages.catalogue import Catalogue


@dataclass(frozen=True)
class Flaw:
    """One thing that is wrong in a file."""

    lesson: int
    function: str
    cause: str
    """A code such as M1, or a word if the mistake has no code."""
    symptom: Words
    """What the mistake does to the filter."""
    case: Words
    """The smallest failing case, with numbers."""
    seems: Words
    """What the code seems to do."""
    advice: Words
    """What to look at next."""
    picture: str = ""
    """The case as SVG; its labels are not translated yet."""
    situation: Mapping[str, float] = field(default_factory=dict)
    """The pose to put the dashboard's robot at: x, y [m], theta [rad]."""
    line: int | None = None

    @property
    def link(self) -> str:
        """Where the dashboard opens in this situation, below its address."""
        query = {key: f"{value:.4f}" for key, value in self.situation.items()}
        return f"/learn/{self.lesson}" + (f"?{urlencode(query)}" if query else "")

    def to_json(self, language: Catalogue = ENGLISH_TEXTS) -> dict[str, Any]:
        """Return the finding as JSON values, in a language."""
        return {
            "lesson": self.lesson,
            "function": self.function,
            "cause": self.cause,
            "symptom": self.symptom.say(language),
            "case": self.case.say(language),
            "seems": self.seems.say(language),
            "next": self.advice.say(language),
            "line": self.line,
            "link": self.link,
            "picture": translated(self.picture, language),
        }


@dataclass(frozen=True)
class LessonResult:
    """The result of one lesson."""

    lesson: int
    name: str
    findings: tuple[Flaw, ...] = ()
    started: bool = True
    """Whether the file has more than stubs of the lesson's functions."""

    @property
    def passed(self) -> bool:
        """Whether nothing is wrong."""
        return self.started and not self.findings
