"""A document's Markdown as HTML; HTML in it is shown as text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token

TITLE = re.compile(r"^# (.+)$", re.MULTILINE)
NO_PART_OF_AN_ADDRESS = re.compile(r"[^\w\- ]")


def title_of(text: str) -> str:
    """Return the first heading without its marks, as ``Ways out`` of ``# Ways `out` ``."""
    heading = TITLE.search(text)
    return heading[1].replace("`", "").strip() if heading else ""


def rendered(text: str) -> str:
    """Return the HTML of a document. Headings can be linked to as on GitHub: ``#ways-out``."""
    markdown = MarkdownIt("js-default", {"html": False})
    markdown.core.ruler.push("anchors", _set_anchors)
    # What may be wider than the page scrolls by itself, with keys as well.
    markdown.add_render_rule("table_open", _open_table)
    markdown.add_render_rule("table_close", _close_table)
    html: str = markdown.render(text)
    # A column without a name has no heading.
    return html.replace("<pre>", '<pre tabindex="0">').replace("<th></th>", "<td></td>")


def _set_anchors(state: Any) -> None:
    tokens: list[Token] = state.tokens
    used: dict[str, int] = {}
    for token, inline in pairwise(tokens):
        if token.type == "heading_open":
            anchor = _anchor(inline)
            times = used[anchor] = used.get(anchor, -1) + 1
            token.attrSet("id", f"{anchor}-{times}" if times else anchor)


def _anchor(inline: Token) -> str:
    words = "".join(part.content for part in inline.children or ())
    return NO_PART_OF_AN_ADDRESS.sub("", words.lower()).replace(" ", "-")


def _open_table(
    renderer: RendererHTML, tokens: Sequence[Token], place: int, options: Any, env: Any
) -> str:
    return f'<div class="wide" tabindex="0">{renderer.renderToken(tokens, place, options, env)}'


def _close_table(
    renderer: RendererHTML, tokens: Sequence[Token], place: int, options: Any, env: Any
) -> str:
    return f"{renderer.renderToken(tokens, place, options, env)}</div>"
