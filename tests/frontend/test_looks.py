"""The dark look and forced colours: what their rules change of the page."""

from __future__ import annotations

import re

import tinycss2

from app.settings.config import ROOT

LOOK = re.compile(r"prefers-color-scheme|forced-colors|data-theme")
CHANGES = re.compile(
    r"--[\w-]+|color-scheme|(border-|outline-|accent-)?color|background|forced-color-adjust"
    r"|border|border-style|border-width|outline"
)


def changed(rules, inside: bool = False) -> list[tuple[str, str]]:
    """Names and values that rules for a look set."""
    found = []
    for rule in rules:
        if rule.type == "declaration" and inside:
            found.append((rule.name, tinycss2.serialize(rule.value).strip()))
        elif rule.type in ("qualified-rule", "at-rule") and rule.content is not None:
            is_look = inside or bool(LOOK.search(tinycss2.serialize(rule.prelude)))
            within = tinycss2.parse_blocks_contents(
                rule.content, skip_comments=True, skip_whitespace=True
            )
            found += changed(within, is_look)
    return found


def test_a_look_changes_colours_and_borders_only() -> None:
    """So that axe looks at the page's structure once, and at colours and sizes in each look."""
    found = []
    for path in sorted((ROOT / "frontend").rglob("*.css")):
        rules = tinycss2.parse_stylesheet(
            path.read_text(encoding="utf-8"), skip_comments=True, skip_whitespace=True
        )
        found += [(path.name, *each) for each in changed(rules)]
    assert len(found) > 40
    assert [each for each in found if not CHANGES.fullmatch(each[1])] == []
    variables = {value for _, name, value in found if name.startswith("--")}
    assert all(re.fullmatch(r"#[0-9a-f]{3,8}|[\d.]+", value) for value in variables), variables
