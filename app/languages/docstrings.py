"""Translates the docstrings of a student's code; the code itself stays the same."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Iterator
from pathlib import Path

from app.languages.catalogue import Catalogue
from app.languages.markup import one_line

WIDTH = 99
QUOTES = '"""'
Described = ast.Module | ast.FunctionDef | ast.ClassDef


def in_language(source: str, language: Catalogue) -> str:
    """Return code with its docstrings in a language; one without a translation stays as it is."""
    lines = source.splitlines()
    for literal in reversed(_docstrings(source)):
        given = _paragraphs(literal)
        said = [language.t(text) for text in given]
        if said != given:
            indent = " " * literal.col_offset
            lines[literal.lineno - 1 : literal.end_lineno] = _written(said, indent)
    return "\n".join(lines) + "\n"


def texts_of_docstrings(path: Path) -> Iterator[str]:
    """Yield each paragraph of a module's docstrings."""
    for literal in _docstrings(path.read_text(encoding="utf-8")):
        yield from _paragraphs(literal)


def _docstrings(source: str) -> list[ast.Constant]:
    """Return all docstrings of a source, in their order."""
    literals = [
        node.body[0].value
        for node in ast.walk(ast.parse(source))
        if isinstance(node, Described) and node.body and isinstance(node.body[0], ast.Expr)
    ]
    texts = [each for each in literals if isinstance(each, ast.Constant)]
    return sorted(
        (each for each in texts if isinstance(each.value, str)), key=lambda each: each.lineno
    )


def _paragraphs(literal: ast.Constant) -> list[str]:
    return [one_line(part) for part in str(literal.value).split("\n\n")]


def _written(paragraphs: list[str], indent: str) -> list[str]:
    """Return a docstring's lines; a short one is closed where it began."""
    wrapped = [
        textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent)
        for text in [QUOTES + paragraphs[0], *paragraphs[1:]]
    ]
    lines = [line for part in wrapped for line in (*part, "")][:-1]
    if len(lines) == 1 and len(lines[0]) + len(QUOTES) <= WIDTH:
        return [lines[0] + QUOTES]
    return [*lines, indent + QUOTES]
