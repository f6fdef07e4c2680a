"""Modules loaded with another value of a constant, or of several, as if their source said so."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from itertools import pairwise
from pathlib import Path
from types import CodeType, ModuleType
from typing import TypeGuard

ROOT = Path(__file__).parents[1]
ROOMS = ("robot", "sim", "app/engine")
"""Where constants are looked for."""


@dataclass(frozen=True)
class Constant:
    """A constant of a module."""

    module: str
    name: str

    @classmethod
    def of(cls, name: str) -> Constant:
        """Return the constant whose dotted name ends so, as ``monitor.TORN``.

        Raises:
            ValueError: no constant has that name, or several have.
        """
        module, _, constant = name.rpartition(".")
        several = [cls(dotted, constant) for dotted in _modules() if _ends(dotted, module)]
        several = [each for each in several if each.stands]
        if not module or len(several) != 1:
            names = ", ".join(each.module for each in several) or "no module"
            raise ValueError(f"{names} has {name!r}; valid is MODULE.NAME of one constant")
        return several[0]

    @property
    def _path(self) -> Path:
        return ROOT / (self.module.replace(".", "/") + ".py")

    @property
    def _source(self) -> str:
        return self._path.read_text("utf-8")

    @property
    def stands(self) -> bool:
        """Whether its module sets it."""
        return any(_place(each, self.name) is not None for each in _parsed(self.module)[1].body)

    @property
    def place(self) -> str:
        """Its file, below the root of the repository."""
        return str(self._path.relative_to(ROOT))

    def expression(self, value: str = "*1") -> str:
        """Return what it is, or becomes by a value, as source text."""
        tree = ast.parse(self._source)
        if value != "*1":
            _change(tree, self.name, value)
        for statement in tree.body:
            place = _place(statement, self.name)
            if place is not None and isinstance(statement, ast.Assign):
                value_tree = statement.value
                if isinstance(statement.targets[0], ast.Tuple):
                    assert isinstance(value_tree, ast.Tuple)
                    value_tree = value_tree.elts[place]
                return ast.unparse(value_tree)
        raise ValueError(f"{self.module} has no {self.name}")

    @property
    def sentence(self) -> str:
        """The first sentence of the text below it; empty if there is none."""
        for statement, following in pairwise(ast.parse(self._source).body):
            if _place(statement, self.name) is None or not isinstance(following, ast.Expr):
                continue
            value = getattr(following.value, "value", None)
            if isinstance(value, str):
                text = " ".join(value.partition("\n\n")[0].split())
                return re.split(r"(?<=[^.][.?!])\s", text, maxsplit=1)[0]
        return ""

    @property
    def compiled_users(self) -> tuple[tuple[str, str], ...]:
        """The compiled functions that have it built in, or call one that has: module and name.

        numba knows constants as they are when it compiles, and keeps what it has compiled.
        """
        importing = re.compile(
            rf"^from {re.escape(self.module)} import (\([^)]*|.*)\b{self.name}\b", re.MULTILINE
        )
        functions = []
        users = []
        for module in _modules():
            source, tree = _parsed(module)
            if "@compiled(" not in source:
                continue
            own = [(module, each) for each in tree.body if _is_compiled(each)]
            functions += own
            if module == self.module or importing.search(source):
                read = _made_of(self.name, tree)
                users += [(module, each) for module, each in own if _names(each, ast.Load) & read]
        while True:
            called = {each.name for _, each in users}
            more = [each for each in functions if each not in users and _calls(each[1], called)]
            if not more:
                return tuple((module, each.name) for module, each in users)
            users += more


def change(constants: Iterable[Constant], value: str) -> None:
    """Let modules, once they are imported, have another value of constants.

    Args:
        constants: all that change, in one call.
        value: an expression; after ``*`` a factor, for each of several numbers. What was whole
            stays whole, and at least 1.
    """
    trees: dict[str, ast.Module] = {}
    for each in constants:
        assert each.module not in sys.modules
        # numba asks where the source is.
        tree = trees.setdefault(each.module, ast.parse(each._source))
        _change(tree, each.name, value)
    for module, tree in trees.items():
        code = compile(tree, Constant(module, "")._path, "exec")
        sys.meta_path.insert(0, _Finder(module, code))


class _Finder(MetaPathFinder):
    def __init__(self, module: str, code: CodeType) -> None:
        self._module, self._code = module, code

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how the one module is loaded; None for all others."""
        spec = PathFinder.find_spec(fullname, path) if fullname == self._module else None
        if spec is not None and spec.origin is not None:
            spec.loader = _ChangedLoader(fullname, spec.origin, self._code)
        return spec


class _ChangedLoader(SourceFileLoader):
    def __init__(self, fullname: str, path: str, code: CodeType) -> None:
        super().__init__(fullname, path)
        self._code = code

    def get_code(self, fullname: str) -> CodeType:
        """Return the changed code."""
        return self._code


@cache
def _modules() -> tuple[str, ...]:
    paths = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    return tuple(".".join(path.relative_to(ROOT).with_suffix("").parts) for path in paths)


@cache
def _parsed(module: str) -> tuple[str, ast.Module]:
    """Return the source of a module, and its tree, which nobody may change."""
    source = Constant(module, "")._source
    return source, ast.parse(source)


def _ends(dotted: str, ending: str) -> bool:
    return f".{dotted}".endswith(f".{ending}")


def _place(statement: ast.stmt, name: str) -> int | None:
    """Return where a name stands among those that are assigned; None if it does not."""
    if not isinstance(statement, ast.Assign):
        return None
    target = statement.targets[0]
    names = [ast.unparse(each) for each in getattr(target, "elts", [target])]
    return names.index(name) if name in names else None


def _is_compiled(statement: ast.stmt) -> TypeGuard[ast.FunctionDef]:
    return isinstance(statement, ast.FunctionDef) and any(
        ast.unparse(each).startswith("compiled(") for each in statement.decorator_list
    )


def _made_of(name: str, tree: ast.Module) -> set[str]:
    """Return a constant's name, and those of a module's constants that are made of it."""
    made = {name}
    for statement in tree.body:
        if isinstance(statement, ast.Assign) and _names(statement, ast.Load) & made:
            made |= _names(statement, ast.Store)
    return made


def _calls(function: ast.FunctionDef, names: set[str]) -> bool:
    return bool(_names(function, ast.Load) & names)


@cache
def _names(statement: ast.stmt, context: type[ast.expr_context]) -> frozenset[str]:
    names = (each for each in ast.walk(statement) if isinstance(each, ast.Name))
    return frozenset(name.id for name in names if isinstance(name.ctx, context))


def _change(tree: ast.Module, name: str, value: str) -> None:
    """Give a module another value of a constant, which may stand in a row of several."""
    for statement in tree.body:
        place = _place(statement, name)
        if place is None or not isinstance(statement, ast.Assign):
            continue
        if isinstance(statement.targets[0], ast.Tuple):
            assert isinstance(statement.value, ast.Tuple)
            elements = statement.value.elts
            elements[place] = _other(elements[place], value)
        else:
            statement.value = _other(statement.value, value)
    ast.fix_missing_locations(tree)


def _other(expression: ast.expr, value: str) -> ast.expr:
    if isinstance(expression, ast.Tuple) and value.startswith("*"):
        return ast.Tuple([_other(each, value) for each in expression.elts], ast.Load())
    text = f"({ast.unparse(expression)}){value}" if value.startswith("*") else value
    if isinstance(expression, ast.Constant) and isinstance(expression.value, int):
        if re.fullmatch(r"\*[\d.]+", value):
            return ast.Constant(max(1, round(expression.value * float(value[1:]))))
        text = f"max(1, round({text}))"
    return ast.parse(text, mode="eval").body
