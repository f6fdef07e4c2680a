"""Translates a page of HTML before it is served, so that it never shows another language."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape, unescape
from html.parser import HTMLParser
from itertools import pairwise

ATTRIBUTES = ("title", "aria-label", "placeholder", "alt", "content")
"""Attributes that people read or hear; ``content`` is a ``<meta>``'s description."""
NO_TEXT = ("script", "style", "code")
VOID = ("meta", "link", "input", "img", "br", "hr")


def translated(page: str, translate: Callable[[str], str]) -> str:
    """Return a page with each text and each attribute for people translated.

    A text is what stands between two tags, without space around it. What is in ``<code>`` or in an
    element with ``translate="no"`` stays.
    """
    reader = _Reader(translate)
    reader.feed(page)
    reader.close()
    return "".join(reader.parts)


class _Reader(HTMLParser):
    def __init__(self, translate: Callable[[str], str]) -> None:
        super().__init__(convert_charrefs=False)
        self.parts: list[str] = []
        self._translate = translate
        self._kept = 0
        """How many elements are open since one whose text stays; 0 outside."""
        self._text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._end_text()
        values = dict(attrs)
        own = self._kept > 0 or tag in NO_TEXT or values.get("translate") == "no"
        if own and tag not in VOID:
            self._kept += 1
        whole = self.get_starttag_text() or ""
        self.parts.append(whole if own else self._with_attributes(whole, tag, values))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._end_text()
        self.parts.append(self.get_starttag_text() or "")

    def handle_endtag(self, tag: str) -> None:
        self._end_text()
        self._kept = max(0, self._kept - 1)
        self.parts.append(f"</{tag}>")

    def handle_data(self, data: str) -> None:
        self._text += data

    def handle_entityref(self, name: str) -> None:
        self._text += f"&{name};"

    def handle_charref(self, name: str) -> None:
        self._text += f"&#{name};"

    def handle_comment(self, data: str) -> None:
        self._end_text()
        self.parts.append(f"<!--{data}-->")

    def handle_decl(self, decl: str) -> None:
        self.parts.append(f"<!{decl}>")

    def close(self) -> None:
        super().close()
        self._end_text()

    def _end_text(self) -> None:
        text, self._text = self._text, ""
        words = unescape(text.strip())
        if self._kept == 0 and is_text(words):
            before, after = text[: text.index(text.strip())], text[len(text.rstrip()) :]
            text = f"{before}{escape(self._translate(one_line(words)), quote=False)}{after}"
        self.parts.append(text)

    def _with_attributes(self, whole: str, tag: str, values: dict[str, str | None]) -> str:
        for name in ATTRIBUTES:
            value = values.get(name)
            described = name != "content" or values.get("name") == "description"
            if value and described and is_text(value):
                new = escape(self._translate(one_line(value)))
                # As it is written: it may have an apostrophe, or one that is escaped.
                was = re.search(rf'(?<=\s){name}="[^"]*"', whole)
                if was:
                    whole = f'{whole[: was.start()]}{name}="{new}"{whole[was.end() :]}'
        return whole


def is_text(words: str) -> bool:
    """Whether there is something to translate: two letters or more, side by side."""
    return any(a.isalpha() and b.isalpha() for a, b in pairwise(words))


def one_line(text: str) -> str:
    """Return a text with every white space as one blank."""
    return " ".join(text.split())
