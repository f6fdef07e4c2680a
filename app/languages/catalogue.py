"""A language's texts, read from its ``.po`` file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from app.languages.templates import Templates, filled

FOLDER = Path(__file__).parent
ENGLISH = "en"
"""The language of the code's own texts."""


@dataclass(frozen=True)
class Catalogue:
    """Texts of one language by their English ones."""

    language: str
    """Its code, as ``de``; ``en`` has no texts, as English stands in the code."""
    texts: Mapping[str, tuple[str, ...]]
    """By English text, which is the singular where there are two; one form, or each plural's."""
    plural: str
    """Which form a number n takes: an expression in C, as gettext has it."""
    point: str
    """Between a number's whole part and its decimals."""

    def t(self, text: str, /, **values: object) -> str:
        """Return a text with ``{names}`` replaced by values, in this language."""
        shown = {name: _shown(value, self.point) for name, value in values.items()}
        return filled(self.texts.get(text, (text,))[0], shown)

    def translated(self, text: str) -> str:
        """Return in this language what the program tells in English, as an error's message.

        The text was made from one of the catalogue's, with values in it; it is found by them. What
        is not known stays English.
        """
        return text if self.language == ENGLISH else _templates(self.language).translated(text)


def languages() -> tuple[str, ...]:
    """Return the codes of all languages, English first."""
    return (ENGLISH, *sorted(path.stem for path in FOLDER.glob("*.po")))


@lru_cache
def catalogue(language: str) -> Catalogue:
    """Return a language's catalogue; English for one that there is not."""
    if language not in languages()[1:]:
        return Catalogue(ENGLISH, {}, "n != 1", ".")
    # A start in English need not wait for it.
    from babel.core import Locale  # noqa: PLC0415
    from babel.messages.pofile import read_po  # noqa: PLC0415

    with (FOLDER / f"{language}.po").open("rb") as file:
        entries = read_po(file, locale=language, abort_invalid=True)
    texts = {_id(entry.id): _forms(entry.string) for entry in entries if entry.id}
    known = {text: forms for text, forms in texts.items() if all(forms)}
    point = Locale.parse(language).number_symbols["latn"]["decimal"]
    return Catalogue(language, known, entries.plural_expr, point)


def spoken(environment: Mapping[str, str] = os.environ) -> Catalogue:
    """Return the catalogue that LANGUAGE, LC_ALL, LC_MESSAGES or LANG asks for, as gettext does."""
    wanted = next(
        (value for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG")
         if (value := environment.get(name))), "",
    )  # fmt: skip
    codes = [code.replace("-", "_").split("_")[0].split(".")[0] for code in wanted.split(":")]
    return catalogue(next((code for code in codes if code in languages()), ENGLISH))


def _id(text: str | tuple[str, ...] | list[str]) -> str:
    return text if isinstance(text, str) else text[0]


def _forms(text: str | tuple[str, ...] | list[str] | None) -> tuple[str, ...]:
    return (text or "",) if isinstance(text, str | None) else tuple(text)


@lru_cache
def _templates(language: str) -> Templates:
    own = catalogue(language)
    return Templates({text: forms[0] for text, forms in own.texts.items()}, own.point)


def _shown(value: object, point: str) -> str:
    return str(value).replace(".", point) if isinstance(value, float) else str(value)
