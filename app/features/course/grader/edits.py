"""``edits``: small changes of a program, each of which would mend one kind of slip."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import combinations, pairwise, permutations

from app.languages.marking import phrase

Make = Callable[[], ast.AST]
Block = ast.For | ast.While | ast.If
"""Statements with lines of their own."""

OPPOSITE: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div, ast.Add),
    ast.Div: (ast.Mult, ast.Sub),
    ast.FloorDiv: (ast.Div,),
    ast.Lt: (ast.Gt,),
    ast.Gt: (ast.Lt,),
    ast.LtE: (ast.GtE,),
    ast.GtE: (ast.LtE,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
    ast.BitAnd: (ast.BitOr,),
    ast.BitOr: (ast.BitAnd,),
    ast.Eq: (ast.NotEq, ast.Lt, ast.Gt),
}
RANKS = (
    "same-array", "sine", "S4", "arctan", "half-cell", "slip-comparison", "slip-range", "slip-sign",
    "line-too-many", "slip-brackets", "slip-loop", "slip-break", "slip-order", "slip-operator",
    "slip-function", "two-missing", "slip-number", "slip-too-much", "slip-name", "slip-missing",
)  # fmt: skip
"""Causes, and some kinds of a cause, in the order in which they are tried; what has a name of its
own comes first."""
SIGNS, COMPARISONS = (ast.Add, ast.Sub), (ast.cmpop, ast.boolop, ast.BitAnd, ast.BitOr)
FUNCTIONS: dict[str, tuple[str, ...]] = {
    "sin": ("cos", "tan"), "cos": ("sin",), "tan": ("sin", "cos"), "arctan": ("tan",),
    "atan": ("tan",),
    "max": ("sum", "min"), "min": ("sum", "max"), "sum": ("max", "min", "prod"),
    "amax": ("sum",), "amin": ("sum",), "mean": ("sum",), "median": ("mean",), "prod": ("sum",),
    "argmax": ("argmin",), "argmin": ("argmax",), "cumprod": ("cumsum",),
    "log": ("exp",), "log10": ("log",), "log2": ("log",), "log1p": ("log",), "exp": ("log",),
    "round": ("floor", "int"), "rint": ("floor",), "ceil": ("floor",), "floor": ("round",),
    "degrees": ("radians",), "radians": ("degrees",), "rad2deg": ("deg2rad",),
    "deg2rad": ("rad2deg",), "sqrt": ("square",),
    "ones": ("zeros",), "zeros": ("ones",), "random": ("standard_normal",),
    "rand": ("standard_normal",),
}  # fmt: skip
"""What is taken for what, by the last part of the function's name."""
NUMBERS = (0, 1, 2, 3, 0.5, 0.95, 0.05, 0.1, 0.001, 0.01, math.pi, math.tau)
"""Numbers that lessons name, besides those of the code itself."""
SAME_ANGLES = ({180, math.pi}, {360, math.tau})
"""The same angle in degrees and in radians."""
CALLED_OFF = frozenset(
    (
        "abs", "fabs", "sqrt", "log", "exp", "square", "radians", "degrees", "deg2rad", "rad2deg",
        "round", "floor", "int", "sorted", "sort", "mean", "max", "arctan", "atan", "sin", "cos",
        "cumsum",
    )
)  # fmt: skip
"""Functions of one argument that can be one too many."""
WRAPPERS: tuple[tuple[str, str], ...] = (
    (phrase("a minus sign"), "-{x}"),
    (phrase("a square root"), "({x}) ** 0.5"),
    (phrase("a square"), "({x}) ** 2"),
    (phrase("an absolute value"), "abs({x})"),
    (phrase("what is left to 1"), "(1 - {x})"),
    (phrase("radians for degrees"), "({x}) * 0.017453292519943295"),
    (phrase("degrees for radians"), "({x}) * 57.29577951308232"),
    (phrase("half of it"), "({x}) / 2"),
    (phrase("twice as much"), "({x}) * 2"),
    (phrase("one over it"), "1 / ({x})"),
    (phrase("an angle brought back to -π to π"), f"(({{x}}) + {math.pi}) % {math.tau} - {math.pi}"),
)
"""What can be missing around a part of a line: in words, and as code."""
TRIGONOMETRY = frozenset(["sin", "cos", "tan", "exp"])
"""Functions of an angle."""
DOUBLED = frozenset(["half of it", "twice as much"])
"""A 2 that is missing in a question, which other numbers of the code could make up for."""
IN_QUESTIONS = DOUBLED | {"an absolute value", "one over it", "a square root", "a square"}
"""What can be missing where something is asked, too, as whether a squared distance is below 0.1."""
ANGLES = frozenset(["radians", "degrees", "deg2rad", "rad2deg"])
"""Functions that change an angle's unit."""
COUNTING = frozenset(["range", "arange"])
"""Functions that count from a number to another."""
BOUNDS = frozenset(["min", "max", "minimum", "maximum"])
"""Functions of two arguments of which the second can be one too many."""
HELD = (("u0", "v0", "height", "forward", "focal"), ("slow", "fast"))
ATTRIBUTES = {name: together for together in HELD for name in together}
"""Values of what lessons hand over, with those that are taken for each other, or forgotten."""
MOST_VALUES = 12
"""Values of a function that are tried as factors and terms."""
LONGEST = 400
"""Longer functions are not mended [parts of their syntax]."""
FEW = 10
"""Of as many changes of a kind any two are tried together; of more only neighbours."""
CAUSE_OF_NAME = {
    "sin": "sine", "cos": "sine", "radians": "S4", "degrees": "S4", "round": "half-cell",
    "rint": "half-cell", "rad2deg": "S4", "deg2rad": "S4",
}  # fmt: skip
"""Functions whose exchange has a name of its own."""
CAUSE_OF_WRAPPER = {
    "a minus sign": "slip-sign", "radians for degrees": "S4", "degrees for radians": "S4",
    "an angle brought back to -π to π": "E2",
}  # fmt: skip


@dataclass(eq=False)
class Edit:
    """One change at one place of a program."""

    cause: str
    words: str
    """What the line would need, in words: ``another sign``."""
    line: int
    kind: tuple[object, ...]
    """Equal for changes of the same kind, which a student makes in several lines at once."""
    parent: ast.AST
    part: str
    make: Make
    index: int | None = None
    lines: tuple[int, ...] = field(default=(), init=False)
    """All lines that change with it in the program that was yielded last."""
    _old: ast.AST | None = field(default=None, init=False)

    def begin(self) -> None:
        """Change the tree."""
        if self.index is None:
            self._old = getattr(self.parent, self.part)
            setattr(self.parent, self.part, self.make())
        else:
            items = getattr(self.parent, self.part)
            self._old = items[self.index]
            items[self.index] = self.make()

    def end(self) -> None:
        """Change it back."""
        if self.index is None:
            setattr(self.parent, self.part, self._old)
        else:
            getattr(self.parent, self.part)[self.index] = self._old


def mended(source: str, functions: Iterable[str], cause: str = "") -> Iterator[tuple[Edit, str]]:
    """Yield changed programs, the likeliest slips first; each with what was changed.

    Args:
        source: a program that Python can read.
        functions: where changes are made; and in what these call.
        cause: the only one whose changes are wanted; empty is any.
    """
    tree = ast.parse(source)
    parts = [ast.unparse(item) for item in tree.body]
    places = _reached(tree, functions)
    candidates = sorted(
        (
            edit
            for place in places
            for edit in _edits(tree.body[place])
            if cause in ("", edit.cause)
        ),
        key=_rank,
    )
    home = {id(inner): place for place in places for inner in ast.walk(tree.body[place])}
    for chosen in _chosen(candidates):
        for edit in chosen:
            edit.begin()
        try:
            changed = {home[id(edit.parent)] for edit in chosen}
            written = [
                _written(item) if place in changed else parts[place]
                for place, item in enumerate(tree.body)
            ]
        except (AttributeError, TypeError, ValueError, RecursionError):
            continue
        finally:
            for edit in reversed(chosen):
                edit.end()
        chosen[0].lines = tuple(sorted({edit.line for edit in chosen}))
        yield chosen[0], "\n".join(written)


def _written(item: ast.stmt) -> str:
    try:
        return ast.unparse(item)
    except AttributeError:  # a statement that is new has no line yet, and few changes make one
        return ast.unparse(ast.fix_missing_locations(item))


def _rank(edit: Edit) -> tuple[int, bool]:
    cause = edit.cause
    if edit.kind[0] == "wrapped":
        doubled = edit.words in DOUBLED and isinstance(edit.parent, ast.Compare)
        cause = "two-missing" if doubled else "slip-missing"
    if edit.kind[:2] == ("lines", "slip-too-much"):
        cause = "line-too-many"
    return RANKS.index(cause), edit.kind[0] == "term"


def _chosen(candidates: list[Edit]) -> Iterator[tuple[Edit, ...]]:
    """Yield each change alone, then two of one kind, all of one kind; at last those that can make
    up for a mistake elsewhere: terms, and angles that are brought back."""
    late = [edit for edit in candidates if _is_late(edit)]
    candidates = [edit for edit in candidates if not _is_late(edit)]
    yield from ((edit,) for edit in candidates)
    kinds: dict[tuple[object, ...], list[Edit]] = {}
    for edit in candidates:
        kinds.setdefault(edit.kind, []).append(edit)
    for alike in kinds.values():
        pairs = combinations(alike, 2) if len(alike) <= FEW else pairwise(alike)
        yield from (pair for pair in pairs if not _nested(pair))
    for alike in kinds.values():
        if 2 < len(alike) < 9 and not _nested(tuple(alike)):
            yield tuple(alike)
    yield from ((edit,) for edit in late)


def _is_late(edit: Edit) -> bool:
    return edit.kind[0] == "term" or edit.cause == "E2"


def _nested(chosen: tuple[Edit, ...]) -> bool:
    """Return whether one change is inside of what another one replaces."""
    places = [(id(edit.parent), edit.part, edit.index) for edit in chosen]
    if len(set(places)) < len(places):
        return True
    for outer in chosen:
        kept = getattr(outer.parent, outer.part)
        kept = kept if outer.index is None else kept[outer.index]
        roots = kept if isinstance(kept, list) else [kept]
        inside = {id(item) for root in roots for item in ast.walk(root)}
        if any(id(inner.parent) in inside for inner in chosen):
            return True
    return False


def _reached(tree: ast.Module, functions: Iterable[str]) -> list[int]:
    """Return where the functions are, and what of the file they use: functions, classes, values."""
    where = {name: place for place, item in enumerate(tree.body) for name in _defined(item)}
    waiting, reached = [name for name in functions if name in where], list[int]()
    while waiting:
        place = where[waiting.pop(0)]
        if place in reached or sum(1 for _ in ast.walk(tree.body[place])) > LONGEST:
            continue
        reached.append(place)
        names = (item.id for item in ast.walk(tree.body[place]) if isinstance(item, ast.Name))
        waiting += [name for name in names if name in where]
    return reached


def _defined(item: ast.stmt) -> list[str]:
    """Return what a statement of the file defines: a function, a class, or values."""
    if isinstance(item, ast.FunctionDef | ast.ClassDef):
        return [item.name]
    targets = item.targets if isinstance(item, ast.Assign) else []
    return [
        inner.id for target in targets for inner in ast.walk(target) if isinstance(inner, ast.Name)
    ]


def _edits(function: ast.stmt) -> Iterator[Edit]:
    names = _names(function)
    numbers = _numbers(function)
    values = _values(function)
    for parent in ast.walk(function):
        yield from _operators(parent)
        yield from _orders(parent)
        yield from _lines(parent)
        for part, index, child in _children(parent):
            if isinstance(child, ast.expr):
                yield from _expressions(parent, part, index, child, names, numbers, values)


def _children(parent: ast.AST) -> Iterator[tuple[str, int | None, ast.AST]]:
    for part, value in ast.iter_fields(parent):
        if isinstance(value, ast.AST):
            yield part, None, value
        elif isinstance(value, list):
            yield from (
                (part, index, item) for index, item in enumerate(value) if isinstance(item, ast.AST)
            )


def _names(function: ast.stmt) -> list[str]:
    """Return names of values in a function: its arguments, and what it sets."""
    names = dict[str, None]()
    for item in ast.walk(function):
        if isinstance(item, ast.arg):
            names[item.arg] = None
        if isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store):
            names[item.id] = None
    return list(names)


def _values(function: ast.stmt) -> list[ast.expr]:
    """Return what a function works with, each once: names, and calls that make a number."""
    values: list[ast.expr] = []
    for item in ast.walk(function):
        if isinstance(item, ast.Call) and _last_name(item.func) in ("sin", "cos", "tan", "sum"):
            values.append(item)
        elif isinstance(item, ast.Attribute) and item.attr in ATTRIBUTES:
            together = ATTRIBUTES[item.attr]
            values += [ast.Attribute(item.value, name, ast.Load()) for name in together]
        elif isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store):
            values.append(ast.Name(item.id, ast.Load()))
    return list({ast.dump(value): value for value in values}.values())[:MOST_VALUES]


def _numbers(function: ast.stmt) -> list[float]:
    own: list[float] = [
        item.value  # type: ignore[misc]
        for item in ast.walk(function)
        if isinstance(item, ast.Constant) and type(item.value) in (int, float)
    ]
    return list(dict.fromkeys([*own, *NUMBERS]))


def _operators(parent: ast.AST) -> Iterator[Edit]:
    line = getattr(parent, "lineno", 0)
    counts = isinstance(parent, ast.AugAssign) and isinstance(parent.value, ast.Constant)
    if isinstance(parent, ast.BinOp | ast.BoolOp | ast.AugAssign) and not counts:
        for new in OPPOSITE.get(type(parent.op), ()):
            yield _operator(parent, "op", None, type(parent.op), new, line)
    if isinstance(parent, ast.Compare):
        for new in OPPOSITE.get(type(parent.ops[0]), ()):
            yield _operator(parent, "ops", 0, type(parent.ops[0]), new, line)


def _operator(
    parent: ast.AST,
    part: str,
    index: int | None,
    old: type[ast.AST],
    new: type[ast.AST],
    line: int,
) -> Edit:
    cause, words = "slip-operator", phrase("another operator")
    if old in SIGNS:
        cause, words = "slip-sign", phrase("another sign")
    elif issubclass(old, COMPARISONS):
        cause, words = "slip-comparison", phrase("another comparison")
    kind = ("operator", old, new) if old not in SIGNS else ("operator", "sign")
    return Edit(cause, words, line, kind, parent, part, new, index)


def _orders(parent: ast.AST) -> Iterator[Edit]:
    """Exchange two arguments, parts of a result, of an index, or of what is unpacked."""
    if isinstance(parent, ast.Call) and len(parent.args) == 2 and not parent.keywords:
        name = _last_name(parent.func)
        cause = "arctan" if name in ("arctan2", "atan2") else "slip-order"
        yield _exchange(parent, "args", [1, 0], cause, name)
    if isinstance(parent, ast.Tuple | ast.List):
        count = len(parent.elts)
        pairs = [(a, b) for a in range(count) for b in range(a + 1, count)] if count < 6 else []
        for first, second in pairs:
            order = list(range(count))
            order[first], order[second] = second, first
            yield _exchange(parent, "elts", order, "slip-order")
        if count == 3:
            yield from (
                _exchange(parent, "elts", order, "slip-order") for order in ([1, 2, 0], [2, 0, 1])
            )


def _exchange(parent: ast.AST, part: str, order: list[int], cause: str, name: str = "") -> Edit:
    items = getattr(parent, part)
    swapped = [items[place] for place in order]
    kind = (part, name, *order)
    line = getattr(parent, "lineno", 0)
    make: Callable[[], object] = lambda: swapped  # noqa: E731
    return Edit(cause, phrase("the other order"), line, kind, parent, part, make)  # type: ignore[arg-type]


def _lines(parent: ast.AST) -> Iterator[Edit]:
    """Put a line later or earlier, leave one out, or move one out of a loop or before it."""
    for part in ("body", "orelse"):
        lines = getattr(parent, part, None)
        if not isinstance(lines, list) or isinstance(parent, ast.ClassDef):
            continue
        yield from _moved(parent, part, lines)
        yield from _joined(parent, part, lines)
        for index, item in enumerate(lines):
            if len(lines) > 1 and not isinstance(item, ast.Return | ast.FunctionDef):
                left = [*lines[:index], *lines[index + 1 :]]
                yield _rewritten(parent, part, left, item, "slip-too-much", phrase("one line less"))
            if isinstance(item, ast.If) and not item.orelse:
                going = ast.While(item.test, item.body, [], lineno=item.lineno)
                changed = [*lines[:index], going, *lines[index + 1 :]]
                words = phrase("while for if")
                yield _rewritten(parent, part, changed, item, "slip-loop", words)
                if isinstance(parent, ast.For | ast.While) and not _leaves(item.body[-1]):
                    ended = _with_body(item, [*item.body, ast.Break()])
                    changed = [*lines[:index], ended, *lines[index + 1 :]]
                    words = phrase("an end of the loop")
                    yield _rewritten(parent, part, changed, item.body[-1], "slip-break", words)
            if isinstance(item, Block):
                yield from _around_block(parent, part, lines, index, item)


def _leaves(item: ast.stmt) -> bool:
    return isinstance(item, ast.Break | ast.Continue | ast.Return | ast.Raise)


def _moved(parent: ast.AST, part: str, lines: list[ast.stmt]) -> Iterator[Edit]:
    """Put each line after or before others of its block, the nearest first."""
    movable = [index for index, item in enumerate(lines) if not isinstance(item, ast.Return)]
    pairs = sorted(permutations(movable, 2), key=lambda pair: abs(pair[0] - pair[1]))
    for old, new in pairs:
        if new == old - 1:  # is the same as putting that line after this one
            continue
        rest = [*lines[:old], *lines[old + 1 :]]
        changed = [*rest[:new], lines[old], *rest[new:]]
        yield _rewritten(parent, part, changed, lines[old], "slip-order", phrase("the other order"))


def _joined(parent: ast.AST, part: str, lines: list[ast.stmt]) -> Iterator[Edit]:
    """Set two values at once: the second is made of what the first was before."""
    for index, (first, second) in enumerate(pairwise(lines)):
        if isinstance(first, ast.Assign) and isinstance(second, ast.Assign):
            target = ast.Tuple([first.targets[0], second.targets[0]], ast.Store())
            both = ast.Assign([target], ast.Tuple([first.value, second.value], ast.Load()))
            changed = [*lines[:index], both, *lines[index + 2 :]]
            words = phrase("this line and the one before it at once")
            yield _rewritten(parent, part, changed, second, "slip-order", words)


def _around_block(
    parent: ast.AST, part: str, lines: list[ast.stmt], index: int, block: Block
) -> Iterator[Edit]:
    """Move lines beside a loop or an if into it, or lines of it out."""
    words = phrase("its place inside or outside of the loop or the if")
    before, after, body = lines[:index], lines[index + 1 :], block.body

    def moved(item: ast.stmt, *new: ast.stmt) -> Edit:
        return _rewritten(parent, part, list(new), item, "slip-order", words)

    if isinstance(block, ast.For | ast.While):
        if before:
            inner = _with_body(block, [before[-1], *body])
            yield moved(before[-1], *before[:-1], inner, *after)
        for count in range(1, len(body)):
            outer = _with_body(block, body[count:])
            yield moved(body[0], *before, *body[:count], outer, *after)
    if len(body) > 1:
        yield moved(body[-1], *before, _with_body(block, body[:-1]), body[-1], *after)
    if after and not _leaves(body[-1]):
        yield moved(after[0], *before, _with_body(block, [*body, after[0]]), *after[1:])


def _with_body(block: Block, body: list[ast.stmt]) -> ast.stmt:
    if isinstance(block, ast.For):
        return ast.For(block.target, block.iter, body, block.orelse, lineno=block.lineno)
    return type(block)(block.test, body, block.orelse, lineno=block.lineno)


def _rewritten(
    parent: ast.AST, part: str, lines: list[ast.stmt], item: ast.stmt, cause: str, words: str
) -> Edit:
    make: Callable[[], object] = lambda: lines  # noqa: E731
    kind = ("lines", cause, item.lineno)
    return Edit(cause, words, item.lineno, kind, parent, part, make)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class _Place:
    """Where an expression stands: what holds it, in which part."""

    parent: ast.AST
    part: str
    index: int | None
    line: int

    def edit(self, cause: str, words: str, kind: tuple[object, ...], new: ast.AST) -> Edit:
        """Return the edit that puts another expression there."""
        return Edit(cause, words, self.line, kind, self.parent, self.part, lambda: new, self.index)


def _expressions(
    parent: ast.AST,
    part: str,
    index: int | None,
    child: ast.expr,
    names: list[str],
    numbers: list[float],
    values: list[ast.expr],
) -> Iterator[Edit]:
    place = _Place(parent, part, index, getattr(child, "lineno", 0))
    if isinstance(parent, ast.Assign | ast.For) and part in ("value", "iter"):
        yield from _copies(place, child)
    if not isinstance(getattr(child, "ctx", ast.Load()), ast.Load):
        return
    if isinstance(child, ast.Slice | ast.Starred | ast.Lambda):
        return
    if isinstance(parent, ast.Call) and part == "func":
        yield from _functions(place, child)
    elif isinstance(child, ast.Constant):
        yield from _constants(place, child, names, numbers)
    else:
        yield from _less(place, child)
        yield from _ranges(place, child)
        yield from _brackets(place, child)
        yield from _terms(place, child, values)
        yield from _named(place, child, names)
        yield from _more(place, child)


def _copies(place: _Place, child: ast.expr) -> Iterator[Edit]:
    """Make a copy of what gets a second name, or whose parts get names: an array, or a part."""
    if isinstance(child, ast.Name | ast.Subscript):
        copied = ast.Call(ast.Attribute(child, "copy", ast.Load()), [], [])
        yield place.edit("same-array", phrase("a copy"), ("copy",), copied)


def _functions(place: _Place, child: ast.expr) -> Iterator[Edit]:
    name = _last_name(child)
    for new in FUNCTIONS.get(name, ()):
        pair = (name, new)
        cause = "slip-function" if "tan" in pair else CAUSE_OF_NAME.get(name, "slip-function")
        kind = ("function", *sorted(pair))
        yield place.edit(cause, phrase("another function"), kind, _renamed(child, new))


def _constants(
    place: _Place, child: ast.Constant, names: list[str], numbers: list[float]
) -> Iterator[Edit]:
    if type(child.value) not in (int, float):
        return
    old: float = child.value  # type: ignore[assignment]
    for value in numbers:
        if value != old:
            kind = ("number", *sorted((old, value)))
            cause = "S4" if {old, value} in SAME_ANGLES else "slip-number"
            yield place.edit(cause, phrase("another number"), kind, ast.Constant(value))
    if isinstance(place.parent, ast.Assign) and old == 0:
        for name in names:
            first = ast.Subscript(ast.Name(name, ast.Load()), ast.Constant(0), ast.Load())
            kind = ("number", str(old), name)
            yield place.edit("slip-number", phrase("a value for the number"), kind, first)
    if isinstance(place.parent, ast.BinOp):
        for name in names:
            value_of = ast.Name(name, ast.Load())
            kind = ("number", str(old), name)
            yield place.edit("slip-number", phrase("a value for the number"), kind, value_of)


def _less(place: _Place, child: ast.expr) -> Iterator[Edit]:
    """Leave out a sign, a term, or a function; or turn a difference or a ratio round."""
    if isinstance(child, ast.UnaryOp) and isinstance(child.op, ast.USub):
        yield place.edit("slip-sign", phrase("no minus sign"), ("minus",), child.operand)
    if isinstance(child, ast.UnaryOp) and isinstance(child.op, ast.Not | ast.Invert):
        yield place.edit("slip-comparison", phrase("the opposite"), ("not",), child.operand)
    if isinstance(child, ast.BinOp) and not isinstance(child.op, ast.MatMult):
        for side in (child.left, child.right):
            kind = ("dropped", type(child.op), ast.dump(side))
            yield place.edit("slip-too-much", phrase("one term less"), kind, side)
    if isinstance(child, ast.BinOp) and isinstance(child.op, ast.Sub):
        turned = ast.BinOp(child.right, ast.Sub(), child.left)
        yield place.edit("slip-sign", phrase("another sign"), ("turned",), turned)
    if isinstance(child, ast.BinOp) and isinstance(child.op, ast.Div):
        turned = ast.BinOp(child.right, ast.Div(), child.left)
        yield place.edit("slip-operator", phrase("the other way round"), ("turned over",), turned)
    if isinstance(child, ast.Call):
        name = _last_name(child.func)
        inner = child.args[0] if child.args else getattr(child.func, "value", None)
        alone = name in CALLED_OFF and len(child.args) < 2
        if inner is not None and (alone or (name in BOUNDS and len(child.args) == 2)):
            cause = "S4" if name in ANGLES else "slip-too-much"
            yield place.edit(cause, phrase("one function less"), ("call", name), inner)
        if name in ("arctan2", "atan2") and len(child.args) == 2:
            ratio = ast.BinOp(child.args[0], ast.Div(), child.args[1])
            yield place.edit("slip-function", phrase("a ratio alone"), ("ratio",), ratio)


def _brackets(place: _Place, child: ast.expr) -> Iterator[Edit]:
    """Take other parts of a formula together: of (a + b) / c, f(a) + b, or a + b / c."""
    made: list[ast.expr] = []
    if isinstance(child, ast.BinOp):
        left, right = child.left, child.right
        if isinstance(left, ast.BinOp) and type(left.op) is not type(child.op):
            inner = ast.BinOp(left.right, child.op, right)
            made.append(ast.BinOp(left.left, left.op, inner))
        if isinstance(right, ast.BinOp) and type(right.op) is not type(child.op):
            inner = ast.BinOp(left, child.op, right.left)
            made.append(ast.BinOp(inner, right.op, right.right))
        alone = isinstance(left, ast.Call) and len(left.args) == 1 and not left.keywords
        if isinstance(left, ast.Call) and alone and _last_name(left.func) != "len":
            made.append(ast.Call(left.func, [ast.BinOp(left.args[0], child.op, right)], []))
    for new in made:
        yield place.edit("slip-brackets", phrase("other brackets"), ("brackets",), new)


def _ranges(place: _Place, child: ast.expr) -> Iterator[Edit]:
    """Let a range begin or end one earlier or later, or a slice take all."""
    words = phrase("one more or one less")
    if isinstance(child, ast.Call) and _last_name(child.func) in COUNTING:
        for index, argument in enumerate(child.args[:2]):
            for operator in (ast.Add, ast.Sub):
                changed = list(child.args)
                changed[index] = ast.BinOp(argument, operator(), ast.Constant(1))
                kind = ("range", operator, index)
                new = ast.Call(child.func, changed, child.keywords)
                yield place.edit("slip-range", words, kind, new)
    if isinstance(child, ast.Subscript) and isinstance(child.slice, ast.Slice):
        yield place.edit("slip-range", words, ("slice",), child.value)


def _terms(place: _Place, child: ast.expr, values: list[ast.expr]) -> Iterator[Edit]:
    """Put in a factor or a term that is one of the function's own values."""
    if not isinstance(child, ast.BinOp | ast.Call | ast.Name | ast.Subscript):
        return
    holds = isinstance(place.parent, ast.BinOp | ast.Assign | ast.Return | ast.Tuple)
    if not holds and not _is_trigonometry(place.parent):
        return
    for value in values:
        for operator, words in (
            (ast.Mult, phrase("another factor")), (ast.Div, phrase("another factor")),
            (ast.Add, phrase("another term")), (ast.Sub, phrase("another term")),
        ):  # fmt: skip
            new = ast.BinOp(child, operator(), value)
            kind = ("term", operator, ast.dump(value))
            yield place.edit("slip-missing", words, kind, new)


def _named(place: _Place, child: ast.expr, names: list[str]) -> Iterator[Edit]:
    """Take another value for the one that is named."""
    if isinstance(child, ast.Name) and child.id in names:
        for name in names:
            if name != child.id:
                kind = ("name", *sorted((child.id, name)))
                yield place.edit(
                    "slip-name", phrase("another value"), kind, ast.Name(name, ast.Load())
                )
    if isinstance(child, ast.Attribute) and child.attr in ATTRIBUTES:
        others = [ast.Attribute(child.value, name, ast.Load()) for name in ATTRIBUTES[child.attr]]
        own = [ast.Name(name, ast.Load()) for name in names]
        for other in (*others, *own):
            if ast.dump(other) != ast.dump(child):
                kind = ("attribute", *sorted((ast.dump(child), ast.dump(other))))
                yield place.edit("slip-name", phrase("another value"), kind, other)


def _more(place: _Place, child: ast.expr) -> Iterator[Edit]:
    """Add what can be missing around an expression."""
    if not isinstance(child, ast.BinOp | ast.Call | ast.Name | ast.Subscript | ast.Attribute):
        return
    if isinstance(place.parent, ast.Subscript | ast.Attribute | ast.For | ast.comprehension):
        return
    asked = isinstance(place.parent, ast.Compare | ast.BoolOp | ast.If | ast.While)
    given = isinstance(place.parent, ast.Assign | ast.Return | ast.Tuple)
    angle = given or _is_trigonometry(place.parent)
    for words, code in WRAPPERS:
        cause = CAUSE_OF_WRAPPER.get(words, "slip-missing")
        fits = {"S4": angle, "E2": given or isinstance(place.parent, ast.Call)}.get(cause, True)
        if words in IN_QUESTIONS or (fits and not asked):
            yield place.edit(cause, words, ("wrapped", code), _wrapped(child, code))
    if isinstance(place.parent, ast.If | ast.While):
        opposite = ast.UnaryOp(ast.Not(), child)
        yield place.edit("slip-comparison", phrase("the opposite"), ("not",), opposite)


def _wrapped(child: ast.expr, code: str) -> ast.expr:
    made = ast.parse(code.format(x="x_"), mode="eval").body
    for item in ast.walk(made):
        for part, index, inner in _children(item):
            if isinstance(inner, ast.Name) and inner.id == "x_":
                if index is None:
                    setattr(item, part, child)
                else:
                    getattr(item, part)[index] = child
                return made
    return made


def _is_trigonometry(item: ast.AST) -> bool:
    return isinstance(item, ast.Call) and _last_name(item.func) in TRIGONOMETRY


def _last_name(function: ast.AST) -> str:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def _renamed(function: ast.AST, name: str) -> ast.AST:
    if isinstance(function, ast.Attribute):
        return ast.Attribute(function.value, name, ast.Load())
    return ast.Name(name, ast.Load())
