"""Styles of each element of a drawing: by its attributes, and by style sheets (CSS)."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import tinycss2
from cssselect2.parser import SelectorError

from robot.fields.drawing.selectors import Element, Selectors, local_name
from robot.fields.drawing.svg_values import NUMBER, SvgError, shown

MAX_STYLE = 64 << 10
"""Longest style sheet [characters]."""

SPACES = ("http://www.w3.org/2000/svg", "")
"""SVG's namespace; drawings that name none are taken, too."""

_NEEDS_UNIT = ("width", "height")
"""In CSS these are nothing without a unit; those that only SVG has are lengths."""

ATTRIBUTE_ONLY = {"transform": "transform attribute"}
"""Attributes that are written otherwise than the property of their name."""

Declared = dict[str, list[str]]
"""All values of each property, the strongest last."""
_HARMLESS = (
    "charset", "color-profile", "counter-style", "font-face", "font-feature-values",
    "font-palette-values", "keyframes", "-webkit-keyframes", "page", "property", "view-transition",
)  # fmt: skip
_TYPES = {"": True, "all": True, "screen": True, "print": False, "speech": False}
_FEATURES = {
    "(prefers-color-scheme: dark)": False,
    "(prefers-color-scheme: light)": True,
    "(color)": True,
    "(monochrome)": False,
}


class Declaration(NamedTuple):
    """One line of CSS."""

    name: str
    value: str
    important: bool


@dataclass(frozen=True, slots=True)
class StyleRule:
    """Declarations for the elements of a chain of selectors."""

    strength: tuple[Any, int]
    """Specificity, then place among all rules."""
    declarations: tuple[Declaration, ...]


class StyleSheet:
    """All rules of a document that hold, by the numbers of their chains of selectors."""

    def __init__(self, root: Element) -> None:
        """Read all style sheets of a document.

        Raises:
            SvgError: one has something that this program does not understand.
        """
        self._selectors = Selectors()
        self._rules: dict[int, StyleRule] = {}
        self._namespaces: dict[str | None, str] = {}
        sheets = [element for element in root.iter() if local_name(element)[1] == "style"]
        length = sum(len(element.text or "") for element in sheets)
        if length > MAX_STYLE:
            raise SvgError(f"the style sheet has {length} characters; valid are {MAX_STYLE}")
        for element in sheets:
            is_css = element.get("type", "text/css").strip().lower() in ("text/css", "")
            if is_css and _media_applies(element.get("media", "all")):
                self._add(_rules(element.text or ""))

    def declared(
        self, top: Element, attributes: frozenset[str], is_root: bool
    ) -> dict[Element, Declared]:
        """Return what is declared for the elements of a tree, by these attributes and by CSS.

        What a <use> shows is a tree of its own: no selector looks out of it.

        Raises:
            SvgError: there are too many selectors for so many elements.
        """
        return {
            element: _cascade(element, attributes, self._matching(chains))
            for element, chains in self._selectors.walk(top, is_root)
        }

    @property
    def has_rules(self) -> bool:
        """Whether there is any rule."""
        return bool(self._rules)

    def _matching(self, chains: set[int]) -> list[StyleRule]:
        """Return the rules of an element at which these chains end, the strongest last."""
        rules = [self._rules[number] for number in chains if number in self._rules]
        return sorted(rules, key=lambda rule: rule.strength)

    def _add(self, nodes: Iterable[Any]) -> None:
        for node in nodes:
            if node.type == "at-rule":
                self._at_rule(node)
            elif node.type == "qualified-rule":
                self._style_rule(node)

    def _style_rule(self, node: Any) -> None:
        try:
            chains = self._selectors.add(node.prelude, self._namespaces)
        except SelectorError:  # browsers leave out the whole rule
            return
        content = tuple(_block(node.content))
        for chain, specificity in chains:
            self._rules[chain] = StyleRule((specificity, chain), content)

    def _at_rule(self, node: Any) -> None:
        name, prelude = node.lower_at_keyword, tinycss2.serialize(node.prelude).strip()
        if name == "media":
            if _media_applies(prelude):
                self._add(_rules(node.content or []))
        elif name == "namespace":
            words = [token for token in node.prelude if token.type in ("ident", "string", "url")]
            if words:
                prefix = words[0].value if len(words) == 2 else None
                self._namespaces[prefix] = words[-1].value
        elif name not in _HARMLESS and not (name == "import" and "font" in prelude.lower()):
            raise SvgError(
                f"the style sheet's {shown(f'@{name}')} is not understood; valid are @media and "
                "rules without any @"
            )


def _cascade(element: Element, attributes: frozenset[str], rules: list[StyleRule]) -> Declared:
    values: defaultdict[str, list[str]] = defaultdict(list)
    for name, value in element.attrib.items():
        if name in attributes and value.strip():
            values[ATTRIBUTE_ONLY.get(name, name)].append(value.strip())
    own = declarations(element.get("style", ""))
    for important in (False, True):
        for block in [*(rule.declarations for rule in rules), own]:
            for declaration in block:
                if declaration.important == important:
                    values[declaration.name].append(declaration.value)
    return dict(values)


def _rules(content: Any) -> list[Any]:
    nodes: list[Any] = tinycss2.parse_rule_list(content, skip_comments=True, skip_whitespace=True)
    return nodes


@lru_cache(maxsize=4096)
def declarations(text: str) -> tuple[Declaration, ...]:
    """Return the declarations of a ``style`` attribute."""
    return tuple(_block(text)) if text.strip() else ()


def _block(content: Any) -> Iterator[Declaration]:
    nodes = tinycss2.parse_blocks_contents(content, skip_comments=True, skip_whitespace=True)
    for node in nodes:
        if node.type in ("qualified-rule", "at-rule"):
            raise SvgError("a style sheet has rules within rules; valid are plain ones")
        if node.type != "declaration":
            continue
        words = [token for token in node.value if token.type != "comment"]
        value = tinycss2.serialize(words).strip()
        name = node.name if node.name.startswith("--") else node.lower_name
        unitless = name in _NEEDS_UNIT and re.fullmatch(NUMBER, value) and float(value) != 0
        if not unitless:
            for single in ("start", "mid", "end") if name == "marker" else ("",):
                full = f"marker-{single}" if single else name
                yield Declaration(full, value, bool(node.important))


def _media_applies(text: str) -> bool:
    """Return whether a screen without further properties is meant by a media query."""
    return any(_query_applies(" ".join(query.lower().split())) for query in text.split(","))


def _query_applies(query: str) -> bool:
    negated = query.startswith("not ")
    parts = query.removeprefix("not ").removeprefix("only ").split(" and ")
    known = _TYPES | {name.replace(": ", ":"): value for name, value in _FEATURES.items()}
    parts = [re.sub(r"\s*:\s*", ":", part) for part in parts]
    unknown = [part for part in parts if part not in known]
    if unknown:
        valid = ", ".join(name for name in [*_TYPES, *_FEATURES] if name)
        raise SvgError(
            f"@media has {shown(unknown[0])}, which is not understood; valid are {valid}"
        )
    return all(known[part] for part in parts) != negated
