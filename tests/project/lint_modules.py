"""Refuse modules that hide what they hold, and two classes of one name: ``make check`` runs this.

* A module's first sentence names what the module defines.
* Constants stand above the second definition, unless they are made of definitions above them.
* A public number of a room whose numbers decide behaviour is explained in the text below it.
* The text says what half and twice of it change, or ``docs/constants.md`` does for its present
  value, or ``unmeasured_constants.txt`` has a reason.
* A public class has a name of its own, so that a search finds one thing.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "robot", "sim", "benchmarks")
DECIDING = (
    "robot/calibration/",
    "robot/driving/",
    "robot/localization/",
    "robot/mapping/",
    "robot/navigation/",
    "robot/scanning/",
    "sim/",
    "app/engine/",
    "app/features/navigation/",
)
"""Rooms whose numbers decide behaviour."""
PROTOCOL = ("sim/hat/", "sim/hat_emulator/")
"""Rooms of emulated hardware: what its numbers are was decided elsewhere."""
MEASURE = "python -m benchmarks.constants --table"
UNMEASURED = Path(__file__).with_name("unmeasured_constants.txt")
"""Deciding rooms' numbers whose text has no measurement, by the reason. It only gets shorter."""
TABLE = Path("docs/constants.md")
"""What half and twice change, by file, constant and value."""
MEASURED = re.compile(
    r"\b(?:half|twice)\b[^.:;]*:|\bwith \d|\bmeasured (?:in|on)\b|\bwithout (?:it|them|this)\b",
    re.IGNORECASE,
)
"""How a text says what was measured: "Half: 2.4 % are missed", "with 0.3 nothing changes"."""
ENDINGS = re.compile(
    r"(?:ations?|ating|at(?:ed|es|e)|ings?|ions?|ers?|ors?|ies|ied|es|ed|e|s|y)$", re.IGNORECASE
)
EMPTY_WORDS = re.compile(
    r"a|all|an|and|are|as|at|be|been|but|by|each|for|from|has|have|how|if|in|is|it|its|no|not|of|on|"
    r"one|only|or|own|robots?|ros|ros2|so|than|that|the|them|there|they|this|to|until|what|when|"
    r"where|which|with"
)
"""Words that say nothing of a module; "robot" stands in every second one."""
SAME_NAME = {
    "Cause": "lessons of teachers are written with it (docs/course.md)",
    "Hypothesis": "the same",
}
"""Names that two public classes share, with the reason."""


def main() -> int:
    """Print what is refused, with its place; 1 if there is anything."""
    bad = [
        *_unnamed_modules(),
        *_late_constants(),
        *_unexplained_numbers(),
        *_unmeasured_numbers(),
        *_classes_of_one_name(),
    ]
    sys.stdout.writelines(f"{line}\n" for line in bad)
    return 1 if bad else 0


def _modules(*folders: str) -> Iterator[tuple[str, ast.Module]]:
    for folder in folders:
        for path in sorted((ROOT / folder).rglob("*.py")):
            yield str(path.relative_to(ROOT)), _parsed(path)


@cache
def _parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


# First sentences


def _unnamed_modules() -> Iterator[str]:
    for place, module in _modules(*FOLDERS, "tests"):
        names = _described(place, module)
        text = ast.get_docstring(module)
        if names and text is not None and not _names_one(_first_sentence(text), place, names):
            shown = ", ".join(node.name for node in names[:3])
            yield f"{place}:1: the first sentence names neither the file nor {shown}"


Definition = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def _described(place: str, module: ast.Module) -> list[Definition]:
    """Return the public definitions that a file is named after; all, if it is after none."""
    path = Path(place)
    if path.name in {"__init__.py", "__main__.py"}:
        return []
    public = [
        node
        for node in module.body
        if isinstance(node, Definition) and not node.name.startswith("_")
    ]
    if place.startswith("tests/"):
        return public
    shared = [len(_stems(node.name) & _stems(path.stem)) for node in public]
    return [node for node, count in zip(public, shared, strict=True) if count == max(shared)]


def _names_one(sentence: str, place: str, names: list[Definition]) -> bool:
    """Return whether a sentence has a word of a name, or two of the text of one definition."""
    said = _stems(sentence)
    if any(said & _stems(name) for name in [Path(place).stem, *(node.name for node in names)]):
        return True
    texts = [_first_sentence(ast.get_docstring(node) or "") for node in names]
    return any(len(said & _stems(text)) >= 2 for text in texts)


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=[.?!])\s", text.partition("\n\n")[0], maxsplit=1)[0]


def _stems(text: str) -> frozenset[str]:
    words = (word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+", text))
    return frozenset(_stem(word) for word in words if not EMPTY_WORDS.fullmatch(word))


def _stem(word: str) -> str:
    """Return a word without its ending: ``mapper``, ``maps`` and ``mapping`` are one."""
    short = ENDINGS.sub("", word, count=1)
    short = short if len(short) >= 3 else word
    return re.sub(r"(.)\1$", r"\1", short) if len(short) > 3 else short


# Constants


def _late_constants() -> Iterator[str]:
    for place, module in _modules(*FOLDERS):
        defined: set[str] = set()
        count = 0
        for node in module.body:
            if isinstance(node, Definition):
                count += 1
                defined.add(node.name)
            elif isinstance(node, ast.Assign | ast.AnnAssign):
                names = _bound(node)
                if _mentioned(node) & defined:
                    defined |= names
                elif count >= 2 and names != {"__all__"}:
                    yield f"{place}:{node.lineno}: {', '.join(sorted(names))} belongs to the top"


def _unexplained_numbers() -> Iterator[str]:
    for place, line, names, text in _deciding_numbers():
        if text is None:
            shown = ", ".join(names)
            yield f"{place}:{line}: {shown} has no text that says what it is, and why"


def _unmeasured_numbers() -> Iterator[str]:
    listed, table = _listed_constants(UNMEASURED), _measured_values(ROOT / TABLE)
    for place, line, values, text in _deciding_numbers():
        for name in values if text is not None else ():
            at, number = f"{place}:{line}", (place, name)
            measured = table.pop(number, None)
            is_listed = listed.pop(number, None) is not None
            if measured is not None and measured != values[name]:
                yield (
                    f"{at}: {name} is {values[name]}, and {TABLE} has measured {measured}"
                    f" ({MEASURE})"
                )
            elif measured is not None or MEASURED.search(text or "") is not None:
                if is_listed:
                    yield f"{at}: {name} is measured, and still on the list"
            elif not is_listed:
                yield (
                    f"{at}: {name} does not say what half and twice change, and neither {TABLE}"
                    f" nor {UNMEASURED.name} has it ({MEASURE} MODULE.{name})"
                )
    for (place, name), line in listed.items():
        yield f"{UNMEASURED.name}:{line}: {place} has no number {name} that decides"
    for place, name in table:
        yield f"{TABLE}: {place} has no number {name} that decides ({MEASURE})"


def _measured_values(path: Path) -> dict[tuple[str, str], str]:
    """Return the values that a table has, by file and constant."""
    lines = path.read_text().splitlines() if path.exists() else []
    rows = [line.strip("| ").split(" | ") for line in lines]
    return {(row[0], row[1]): row[2] for row in rows if row[0].endswith(".py")}


def _listed_constants(path: Path) -> dict[tuple[str, str], int]:
    """Return the line of each constant of a list, by its file and name.

    A line is ``file: NAMES``, with more names in lines below that are indented.
    """
    lines: dict[tuple[str, str], int] = {}
    place = ""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith(("#", "[")):
            continue
        file, colon, names = line.rpartition(":")
        place = file if colon else place
        lines |= {(place, name): number for name in names.split()}
    return lines


def _deciding_numbers() -> Iterator[tuple[str, int, dict[str, str], str | None]]:
    """Yield file, line, values by name and text of each statement that sets public numbers."""
    for place, module in _modules("robot", "sim", "app"):
        if not place.startswith(DECIDING) or place.startswith(PROTOCOL):
            continue
        for node, following in pairwise([*module.body, ast.Pass()]):
            if not isinstance(node, ast.Assign) or not _is_number(node.value):
                continue
            public = {
                name: value for name, value in _values(node).items() if not name.startswith("_")
            }
            if public:
                yield place, node.lineno, public, _text(following)


def _values(node: ast.Assign) -> dict[str, str]:
    """Return what each name is set to, as source text."""
    target = node.targets[0]
    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
        pairs = list(zip(target.elts, node.value.elts, strict=True))
    else:
        pairs = [(each, node.value) for each in node.targets]
    return {ast.unparse(name): ast.unparse(value) for name, value in pairs}


def _is_number(value: ast.expr) -> bool:
    """Return whether a value is a number, or several: in a row, in an array, or computed."""
    parts = list(ast.walk(value))
    calls = [ast.unparse(each.func) for each in parts if isinstance(each, ast.Call)]
    constants = [type(each.value) for each in parts if isinstance(each, ast.Constant)]
    return (
        bool(constants)
        and all(kind in (int, float) for kind in constants)
        and all(call.startswith(("np.", "math.")) for call in calls)
        and isinstance(value, ast.Constant | ast.Tuple | ast.UnaryOp | ast.BinOp | ast.Call)
    )


def _text(node: ast.stmt) -> str | None:
    """Return the text that a statement is, in one line; None if it is none."""
    if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Constant):
        return None
    value = node.value.value
    return " ".join(value.split()) if isinstance(value, str) else None


def _bound(node: ast.Assign | ast.AnnAssign) -> set[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    inner = (item for target in targets for item in ast.walk(target))
    return {item.id for item in inner if isinstance(item, ast.Name)}


def _mentioned(node: ast.AST) -> set[str]:
    return {
        item.id
        for item in ast.walk(node)
        if isinstance(item, ast.Name) and isinstance(item.ctx, ast.Load)
    }


# Classes


def _classes_of_one_name() -> Iterator[str]:
    found: dict[str, list[str]] = defaultdict(list)
    for place, module in _modules(*FOLDERS):
        for node in module.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].append(f"{place}:{node.lineno}")
    for name, places in sorted(found.items()):
        if len(places) > 1 and name not in SAME_NAME:
            yield f"{places[0]}: class {name} stands for another thing in {', '.join(places[1:])}"
    for name in sorted(SAME_NAME):
        if len(found[name]) < 2:
            yield f"{Path(__file__).name}: class {name} stands for one thing: no reason is needed"


if __name__ == "__main__":
    sys.exit(main())
