"""Text for people as a template with its values, so that it can be said in any language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from app.languages.catalogue import Catalogue, catalogue

ENGLISH_TEXTS = catalogue("en")


@dataclass(frozen=True)
class Words:
    """A sentence or more: an English template, and the values for its ``{places}``."""

    text: str
    values: Mapping[str, object] = field(default_factory=dict)

    def say(self, language: Catalogue = ENGLISH_TEXTS) -> str:
        """Return the text; values are said in the same language."""
        said = {name: _said(value, language) for name, value in self.values.items()}
        return language.t(self.text, **said)


def _said(value: object, language: Catalogue) -> object:
    if isinstance(value, Words):
        return value.say(language)
    return language.translated(value) if isinstance(value, str) else value
