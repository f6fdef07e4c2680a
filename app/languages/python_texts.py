"""Finds texts for people in Python: messages of errors, and what is marked or listed."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path

from app.languages.markup import is_text, one_line

TELLING = ("HTTPException", "fail", "note", "report", "setting")
"""Calls, besides errors, whose texts are for people where the page shows them."""
LAST_NAME = re.compile(r"([A-Za-z_]\w*)\W*$")


def texts_of_module(path: Path, errors: bool, all_of_it: bool) -> Iterator[str]:
    """Yield a module's texts: what is marked, and if asked messages of errors, or every sentence.

    An f-string is a text with a place for each of its values, as ``templates.py`` finds it again.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    if all_of_it:
        left_out = {id(node) for node in ast.walk(tree) if _is_for_programmers(node)}
        yield from (each for each in _texts(tree, left_out) if " " in each)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = _called(node)
        if name == "phrase" or (name == "t" and isinstance(node.func, ast.Attribute)):
            yield from _texts_in(node.args[:1])
        elif errors and (name in TELLING or name.endswith("Error")):
            yield from (each for each in _texts_in(node.args) if " " in each)


def _is_for_programmers(node: ast.AST) -> bool:
    """Return whether a statement is documentation or writes to the log."""
    if not isinstance(node, ast.Expr):
        return False
    value = node.value
    logs = isinstance(value, ast.Call) and ast.unparse(value.func).startswith("LOG.")
    return logs or isinstance(value, ast.Constant)


def _called(node: ast.Call) -> str:
    if isinstance(node.func, ast.Name):
        return node.func.id
    return node.func.attr if isinstance(node.func, ast.Attribute) else ""


def _texts_in(nodes: Iterable[ast.expr]) -> Iterator[str]:
    for node in nodes:
        yield from _texts(node, set())


def _texts(node: ast.AST, left_out: set[int]) -> Iterator[str]:
    """Yield the outermost texts below a node, then what stands in their places."""
    if id(node) in left_out:
        return
    pieces = _pieces(node)
    if pieces is None:
        for child in ast.iter_child_nodes(node):
            yield from _texts(child, left_out)
        return
    text = one_line(_with_places(pieces))
    if is_text(re.sub(r"\{\w+\}", "", text)):
        yield text
    for piece in pieces:
        if isinstance(piece, ast.expr):
            yield from _texts(piece, left_out)


def _pieces(node: ast.AST) -> list[str | ast.expr] | None:
    """Return what a text is made of, fixed parts and values; None if the node is no text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.JoinedStr):
        return [part for value in node.values for part in _part(value)]
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        sides = [(_pieces(side), side) for side in (node.left, node.right)]
        if any(pieces is not None for pieces, _ in sides):
            return [part for pieces, side in sides for part in pieces or [side]]
    return None


def _part(node: ast.expr) -> list[str | ast.expr]:
    if isinstance(node, ast.FormattedValue):
        return [node.value]
    return _pieces(node) or []


def _with_places(pieces: list[str | ast.expr]) -> str:
    names: dict[str, str] = {}
    return "".join(
        piece if isinstance(piece, str) else "{" + _name(piece, names) + "}" for piece in pieces
    )


def _name(value: ast.expr, names: dict[str, str]) -> str:
    """Return the name of a value's place: its own last one, numbered if another has it already."""
    source = ast.unparse(value)
    if source not in names:
        last = LAST_NAME.search(source)
        own = last[1].lower() if last else "value"
        wanted = (own if number == 1 else f"{own}{number}" for number in count(1))
        names[source] = next(name for name in wanted if name not in names.values())
    return names[source]
