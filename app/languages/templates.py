"""Translates finished texts: finds the text with places for values that one was made from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

PLACE = re.compile(r"\{(\w+)\}")
"""Where a value stands in a text; also what the page's ``language.js`` takes for one."""
NUMBER = re.compile(r"-?\d+\.\d+(?:e[+-]?\d+)?")
ROW = re.compile(r"(?:-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?:, |$)){2,}(?:\.\.\.)?")
"""Numbers in a row; maybe more of them are left out."""
BETWEEN = ("; ", ": ", ". ", ", ")
"""What joins texts that are made apart."""
DEEPEST = 6
"""How deep texts are searched for in each other: an error can quote an error."""
LOOSE = 2
"""Letters of a text that begins with a value and could be found in nearly any sentence."""
FEW_WORDS = r"(?:\S+(?: \S+){0,2})?"


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
        if ROW.fullmatch(text):
            return self._row(text)
        if depth > DEEPEST or not any(char.isalpha() for char in text):
            return text
        for each in self._templates:
            match = each.pattern.fullmatch(text) if each.longest in text else None
            if match is not None:
                values = match.groupdict().items()
                own = {name: self._inside(value, depth + 1) for name, value in values}
                return filled(each.translation, own)
        return self._by_parts(text, depth)

    def _inside(self, value: str, depth: int) -> str:
        """Return what stands in a place, with the space around it, which is no part of a text."""
        bare = value.strip()
        return value.replace(bare, self.translated(bare, depth), 1) if bare else value

    def _row(self, text: str) -> str:
        """Return numbers with their decimal signs, and apart where a comma is one."""
        if self.point == ".":
            return text
        numbers, dots = text.removesuffix("..."), "..." if text.endswith("...") else ""
        return numbers.replace(", ", "; ").replace(".", self.point) + dots

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
    letters = sum(char.isalpha() for part in fixed for char in part)
    loose = not fixed[0] and 0 < letters <= LOOSE
    pattern = "".join(_alternating(fixed, names, FEW_WORDS if loose else ".*?"))
    return Template(
        re.compile(pattern, re.DOTALL),
        max(fixed, key=len),
        sum(len(part.strip()) for part in fixed),
        translation,
    )


def _alternating(fixed: list[str], names: list[str], value: str) -> Iterator[str]:
    for number, part in enumerate(fixed):
        yield re.escape(part)
        if number < len(names):
            name = names[number]
            # The same value stands wherever its name does.
            yield f"(?P={name})" if name in names[:number] else f"(?P<{name}>{value})"
