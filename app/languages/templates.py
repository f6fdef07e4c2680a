"""Translates finished texts: finds the text with places for values that one was made from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

PLACE = re.compile(r"\{(\w+)\}")
"""Where a value stands in a text; also what the page's ``language.js`` takes for one."""
NUMBER = re.compile(r"-?\d+\.\d+")
BETWEEN = ("; ", ": ", ". ", ", ")
"""What joins texts that are made apart."""
DEEPEST = 6
"""So many texts in each other are looked for: an error quotes an error."""


@dataclass(frozen=True)
class Template:
    """One text with places for values."""

    pattern: re.Pattern[str]
    longest: str
    """Of its fixed parts: quickly tells most texts apart."""
    certainty: int
    """How many characters of it are fixed."""
    translation: str


@dataclass(frozen=True)
class Templates:
    """All texts of a language, ready to be found again in finished ones."""

    texts: Mapping[str, str]
    point: str
    """Between a number's whole part and its decimals."""
    _templates: tuple[Template, ...] = field(init=False)

    def __post_init__(self) -> None:
        made = [template(text, own) for text, own in self.texts.items() if PLACE.search(text)]
        made.sort(key=lambda each: -each.certainty)
        object.__setattr__(self, "_templates", tuple(made))

    def translated(self, text: str, depth: int = 0) -> str:
        """Return a text in the language, with what stands in its places translated, too."""
        if text in self.texts:
            return self.texts[text]
        if NUMBER.fullmatch(text):
            return text.replace(".", self.point)
        if depth > DEEPEST or not any(char.isalpha() for char in text):
            return text
        for each in self._templates:
            match = each.pattern.fullmatch(text) if each.longest in text else None
            if match is not None:
                values = match.groupdict().items()
                own = {name: self.translated(value, depth + 1) for name, value in values}
                return filled(each.translation, own)
        return self._by_parts(text, depth)

    def _by_parts(self, text: str, depth: int) -> str:
        for mark in BETWEEN:
            first, between, rest = text.partition(mark)
            if between:
                own = self.translated(first, depth + 1)
                return f"{own}{mark}{self.translated(rest, depth + 1)}"
        return text


def filled(text: str, values: Mapping[str, str]) -> str:
    """Return a text with values in its places; a place without one stays."""
    return PLACE.sub(lambda place: values.get(place[1], place[0]), text)


def template(text: str, translation: str) -> Template:
    """Make the template of a text."""
    pieces = PLACE.split(text)
    fixed, names = pieces[::2], pieces[1::2]
    pattern = "".join(_alternating(fixed, names))
    return Template(
        re.compile(pattern, re.DOTALL),
        max(fixed, key=len),
        sum(len(part.strip()) for part in fixed),
        translation,
    )


def _alternating(fixed: list[str], names: list[str]) -> Iterator[str]:
    for number, part in enumerate(fixed):
        yield re.escape(part)
        if number < len(names):
            name = names[number]
            # The same value stands wherever its name does.
            yield f"(?P={name})" if name in names[:number] else f"(?P<{name}>.*?)"
