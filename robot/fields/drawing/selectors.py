"""Which elements the selectors of a style sheet choose, in one walk over the document.

A selector such as ``#plan g > .tape`` is a chain of compounds. For each element it is noted which
beginnings of chains end at it; so a longer beginning asks only what is noted of its parent, of all
above, and of those before it. The time is that of elements times compounds, whatever the chains
are, and most compounds are not even asked, for they name an id, a class or a kind of element.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING, Any, TypeAlias
from xml.etree import ElementTree

from cssselect2 import parser
from tinycss2.nth import parse_nth

from robot.fields.drawing.svg_values import SvgError, shown

MAX_TESTS = 3_000_000
"""Most compounds that are tried on elements: some seconds."""

MAX_NESTED = 8
"""Most selectors within each other, as in ``:not(:is(...))``."""

if TYPE_CHECKING:
    Element: TypeAlias = ElementTree.Element[str]
else:  # it is generic for type checkers alone
    Element = ElementTree.Element

_NEVER = (
    "active", "checked", "disabled", "enabled", "focus", "focus-visible", "focus-within", "hover",
    "target", "visited",
)  # fmt: skip
"""What a drawing on the floor never is."""
_COMPARISONS: dict[str | None, Callable[[str, str], bool]] = {
    None: lambda _has, _value: True,
    "=": lambda has, value: has == value,
    "~=": lambda has, value: value in has.split(),
    "|=": lambda has, value: has == value or has.startswith(f"{value}-"),
    "^=": lambda has, value: value != "" and has.startswith(value),
    "$=": lambda has, value: value != "" and has.endswith(value),
    "*=": lambda has, value: value != "" and value in has,
}


@dataclass(frozen=True, slots=True)
class Place:
    """Where an element stands among its siblings; numbers begin at 1."""

    element: Element
    space: str
    name: str
    classes: frozenset[str]
    is_root: bool
    number: int
    from_end: int
    number_of_type: int
    from_end_of_type: int
    reached: set[int] = field(default_factory=set)
    """The compounds whose chain, up to them, ends here."""


Test = Callable[[Place], bool]


@dataclass(slots=True)
class Compound:
    """One step of a chain."""

    number: int
    tests: list[Test]
    combinator: str
    """How the previous one is reached: a space, ``>``, ``+`` or ``~``; empty for the first."""
    previous: int
    key: tuple[str, str]
    """An id, a class or a name that every such element has; ("", "") if there is none."""


class Selectors:
    """Selectors, to be matched together."""

    def __init__(self) -> None:
        self._compounds: list[Compound] = []
        self._by_key: defaultdict[tuple[str, str], list[Compound]] = defaultdict(list)
        self._tests = 0

    def add(self, prelude: list[Any], namespaces: dict[str | None, str]) -> list[tuple[int, Any]]:
        """Add a rule's selectors; return for each the number of its chain, and its specificity.

        Raises:
            SvgError: browsers understand it, but this program does not.
            parser.SelectorError: it is not valid; browsers leave out its rule.
        """
        selectors = list(parser.parse(prelude, namespaces))
        return [
            (self._chain(selector.parsed_tree, 0), selector.specificity)
            for selector in selectors
            if selector.pseudo_element is None
        ]

    def _chain(self, tree: Any, nested: int) -> int:
        """Add a chain; return the number of its last compound."""
        if nested > MAX_NESTED:
            raise SvgError(f"selectors nested deeper than {MAX_NESTED}; use simpler ones")
        steps: list[tuple[str, Any]] = []
        while isinstance(tree, parser.CombinedSelector):
            steps.append((tree.combinator, tree.right))
            tree = tree.left
        steps.append(("", tree))
        last = -1
        for combinator, compound in reversed(steps):
            simple = compound.simple_selectors
            # What lies within it gets lower numbers: it is asked before.
            tests = [self._test(part, nested) for part in simple]
            step = Compound(len(self._compounds), tests, combinator, last, _key(simple))
            self._compounds.append(step)
            self._by_key[step.key].append(step)
            last = step.number
        return last

    def _test(self, simple: Any, nested: int) -> Test:
        if isinstance(simple, parser.NegationSelector):
            inner = self._inner(simple, nested)
            return lambda place: inner.isdisjoint(place.reached)
        if isinstance(simple, parser.MatchesAnySelector | parser.SpecificityAdjustmentSelector):
            inner = self._inner(simple, nested)
            return lambda place: not inner.isdisjoint(place.reached)
        return _simple_test(simple)

    def _inner(self, simple: Any, nested: int) -> set[int]:
        return {self._chain(part.parsed_tree, nested + 1) for part in simple.selector_list}

    def walk(self, top: Element, is_root: bool) -> Iterator[tuple[Element, set[int]]]:
        """Yield the elements of a tree, the first one first, with the chains that end at them.

        Raises:
            SvgError: there are too many selectors for so many elements.
        """
        if not self._compounds:
            yield from ((element, set()) for element in top.iter())
            return
        first = next(_places([top], is_root))
        yield from self._walk(first, set(), set(), set(), set())

    def _walk(
        self, place: Place, parent: set[int], above: set[int], last: set[int], before: set[int]
    ) -> Iterator[tuple[Element, set[int]]]:
        around = {"": None, ">": parent, " ": above, "+": last, "~": before}
        for step in self._asked(place):
            noted = around[step.combinator]
            led_to = noted is None or step.previous in noted
            if led_to and all(test(place) for test in step.tests):
                place.reached.add(step.number)
        yield place.element, place.reached
        above = above | place.reached if len(place.element) else above
        last, before = set(), set()
        for child in _places(list(place.element), is_root=False):
            yield from self._walk(child, place.reached, above, last, before)
            last = child.reached
            before |= last

    def _asked(self, place: Place) -> Iterable[Compound]:
        """Return the compounds that an element can be, in the order of their numbers."""
        keys = [("", ""), ("name", place.name), ("id", place.element.get("id", ""))]
        keys += [("class", name) for name in place.classes]
        candidates = [self._by_key[key] for key in keys if key in self._by_key]
        self._tests += sum(map(len, candidates))
        if self._tests > MAX_TESTS:
            raise SvgError(
                "the style sheet has too many selectors for so many elements; valid are up to "
                f"{MAX_TESTS} pairs of them: give the elements attributes of their own"
            )
        return sorted(chain(*candidates), key=lambda step: step.number)


def local_name(element: Element) -> tuple[str, str]:
    """Return an element's namespace and its name."""
    space, _, name = element.tag.rpartition("}")
    return space.removeprefix("{"), name


def _places(elements: list[Element], is_root: bool) -> Iterator[Place]:
    """Yield the places of siblings."""
    total, of_type = len(elements), Counter(element.tag for element in elements)
    seen: Counter[str] = Counter()
    for number, element in enumerate(elements, 1):
        seen[element.tag] += 1
        rank = seen[element.tag]
        yield Place(
            element, *local_name(element), frozenset(element.get("class", "").split()), is_root,
            number, total - number + 1, rank, of_type[element.tag] - rank + 1,
        )  # fmt: skip


def _key(simple: list[Any]) -> tuple[str, str]:
    for kind, name, attribute in (
        (parser.IDSelector, "id", "ident"),
        (parser.ClassSelector, "class", "class_name"),
        (parser.LocalNameSelector, "name", "local_name"),
    ):
        for part in simple:
            if isinstance(part, kind):
                return name, getattr(part, attribute)
    return "", ""


def _simple_test(simple: Any) -> Test:
    """Return the test of one simple selector that has no others within it."""
    make = _TESTS.get(type(simple))
    if make is None:
        raise SvgError(f"the selector {shown(repr(simple))} is not understood; use a class")
    return make(simple)


_STATES: dict[str, Test] = {
    "root": lambda place: place.is_root,
    "first-child": lambda place: place.number == 1,
    "last-child": lambda place: place.from_end == 1,
    "only-child": lambda place: place.number == place.from_end == 1,
    "first-of-type": lambda place: place.number_of_type == 1,
    "last-of-type": lambda place: place.from_end_of_type == 1,
    "only-of-type": lambda place: place.number_of_type == place.from_end_of_type == 1,
    "empty": lambda place: not len(place.element) and not place.element.text,
}


def _state_test(simple: Any) -> Test:
    name = simple.name
    if name in _NEVER:
        return lambda _: False
    if name not in _STATES:
        valid = ", ".join(f":{part}" for part in _STATES)
        raise SvgError(f"the selector {shown(f':{name}')} is not understood; valid are {valid}")
    return _STATES[name]


_COUNTED: dict[str, Callable[[Place], int]] = {
    "nth-child": lambda place: place.number,
    "nth-last-child": lambda place: place.from_end,
    "nth-of-type": lambda place: place.number_of_type,
    "nth-last-of-type": lambda place: place.from_end_of_type,
}


def _nth_test(simple: Any) -> Test:
    every = parse_nth(simple.arguments) if simple.name in _COUNTED else None
    if every is None:
        valid = ", ".join(f":{part}(2n+1)" for part in _COUNTED)
        raise SvgError(
            f"the selector {shown(f':{simple.name}()')} is not understood; valid are {valid}"
        )
    step, offset = every
    counted = _COUNTED[simple.name]

    def test(place: Place) -> bool:
        beyond = counted(place) - offset
        return bool(beyond == 0 if step == 0 else beyond % step == 0 and beyond // step >= 0)

    return test


def _attribute_test(simple: Any) -> Test:
    name = f"{{{simple.namespace}}}{simple.name}" if simple.namespace else simple.name
    compare = _COMPARISONS[simple.operator]
    folded = simple.case_sensitive is False
    wanted = (simple.value or "").lower() if folded else simple.value or ""

    def test(place: Place) -> bool:
        has = place.element.get(name)
        if has is None:
            return False
        return compare(has.lower() if folded else has, wanted)

    return test


_TESTS: dict[type, Callable[[Any], Test]] = {
    parser.LocalNameSelector: lambda simple: lambda place: place.name == simple.local_name,
    parser.NamespaceSelector: lambda simple: lambda place: place.space == simple.namespace,
    parser.IDSelector: lambda simple: lambda place: place.element.get("id") == simple.ident,
    parser.ClassSelector: lambda simple: lambda place: simple.class_name in place.classes,
    parser.AttributeSelector: _attribute_test,
    parser.FunctionalPseudoClassSelector: _nth_test,
    parser.PseudoClassSelector: _state_test,
}
