"""A lesson's Markdown as HTML, in sections; links that begin with ``do:`` become buttons."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html import escape
from urllib.parse import parse_qsl, urlsplit

from markdown_it import MarkdownIt

Values = dict[str, object]
HEADING = re.compile(r"^## (.+)$", re.MULTILINE)
CHOICE = re.compile(r"^- (.+)$", re.MULTILINE)
ACTION = re.compile(r'<a href="do:([^"]*)">(.*?)</a>')
NESTED: Mapping[str, Callable[[Values], dict[str, object]]] = {
    "set_parameters": lambda values: {"values": values},
    "navigate": lambda values: {"poses": [values]},
}
"""Commands whose values are not beside their type."""
MARKDOWN = MarkdownIt("js-default", {"html": False})
MARKDOWN.validateLink = lambda url: url.startswith(("do:", "/", "https://"))  # type: ignore[method-assign]


@dataclass(frozen=True)
class Section:
    """A part of a lesson below one heading."""

    title: str
    html: str
    choices: tuple[str, ...] = ()
    """Answers that can be clicked; only the first section has them."""


@dataclass(frozen=True)
class LessonText:
    """A lesson in one language."""

    title: str
    """The question."""
    html: str
    """What stands above the first section."""
    sections: tuple[Section, ...]


def parsed(text: str) -> LessonText:
    """Return a lesson's Markdown in parts."""
    head, *rest = HEADING.split(text)
    title, _, opening = head.strip().partition("\n")
    pairs = zip(rest[::2], rest[1::2], strict=True)
    sections = [_section(name, body, asks=index == 0) for index, (name, body) in enumerate(pairs)]
    return LessonText(title.removeprefix("# ").strip(), rendered(opening), tuple(sections))


def rendered(text: str) -> str:
    """Return Markdown as HTML; HTML in it is shown as text."""
    return ACTION.sub(_button, MARKDOWN.render(text))


def _section(name: str, body: str, *, asks: bool) -> Section:
    choices = tuple(CHOICE.findall(body)) if asks else ()
    return Section(name.strip(), rendered(CHOICE.sub("", body) if asks else body), choices)


def _button(match: re.Match[str]) -> str:
    """Return a button that sends a command, as ``do:place?x=0.3``."""
    parts = urlsplit(match[1].replace("&amp;", "&"))
    values: Values = {key: _value(item) for key, item in parse_qsl(parts.query)}
    nesting = NESTED.get(parts.path)
    nested = values if nesting is None else nesting(values)
    command = {"type": parts.path, **nested}
    data = escape(json.dumps(command), quote=True)
    return f'<button type="button" data-command="{data}">{match[2]}</button>'


def _value(text: str) -> float | str | bool:
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text
