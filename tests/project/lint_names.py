"""Refuse names that are prepositions, participles, adverbs or numerals: ``make check`` runs this.

``told`` or ``then`` says nothing of what it holds. Accessors that take or return a time are named
so everywhere (``odometry.at(stamp)``, ``clock.now``), as are constructors (``Setup.of(...)``).
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "robot", "sim", "benchmarks")
PREPOSITIONS = frozenset(["at", "by", "from", "in", "into", "of", "off", "on", "to", "with"])
ADVERBS = frozenset(["again", "anew", "else", "here", "now", "once", "the", "then", "there"])
PARTICIPLES = frozenset(["found", "told"])
QUESTIONS = frozenset(["what", "which", "who"])
NUMERALS = frozenset(["one", "two", "three"])
REFUSED = PREPOSITIONS | ADVERBS | PARTICIPLES | NUMERALS | QUESTIONS
ACCESSORS = frozenset(["at", "now", "of"])
"""As names of functions and properties alone."""
ALLOWED = {
    ("app/features/recordings/messages.py", "on"): "a field of the live protocol",
    ("app/features/weighing/messages.py", "on"): "the same",
}


def main() -> int:
    """Print each refused name with its place; 1 if there are any."""
    bad = [
        f"{place}:{line}: {name!r} says nothing of what it holds"
        for place, line, name in _refused()
        if (place, name) not in ALLOWED
    ]
    sys.stdout.writelines(f"{line}\n" for line in bad)
    return 1 if bad else 0


def _refused() -> Iterator[tuple[str, int, str]]:
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            place = str(path.relative_to(ROOT))
            for node in ast.walk(ast.parse(path.read_text())):
                name = _bound_name(node)
                if name is not None and name.strip("_") in REFUSED:
                    yield place, getattr(node, "lineno", 0), name


def _bound_name(node: ast.AST) -> str | None:
    """Return the name that a node gives to something, if it does."""
    if isinstance(node, ast.Name):
        return node.id if isinstance(node.ctx, ast.Store) else None
    if isinstance(node, ast.arg):
        return node.arg
    if isinstance(node, ast.ClassDef):
        return node.name
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
        return None if node.name in ACCESSORS else node.name
    return None


if __name__ == "__main__":
    sys.exit(main())
