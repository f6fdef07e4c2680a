"""Cases: what the grader asks of a student's function; and outcomes: what it gets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from app.features.course.grader.words import Words
from app.features.course.sandbox.student_process import Answer
from robot.errors import BrickPoseError
from robot.geometry import Array

REFERENCE: frozenset[str] = frozenset()
"""The reference is the variant without mistakes."""
Chosen = TypeVar("Chosen")
Ask = Callable[..., Answer]
"""Calls the student's function with arguments, and ``seed`` for a generator."""
Play = Callable[[Ask], Any]
"""Calls it as often as it likes; what it returns is the outcome's result."""


class FormError(BrickPoseError, ValueError):
    """A result has the wrong form; ``words`` says which one is wanted."""

    cause = "form"

    def __init__(self, text: str, **values: object) -> None:
        self.words = Words(text, values)
        super().__init__(self.words.say())


class NoNumberError(FormError):
    """A result has the right form, and something in it is infinite or not a number."""

    cause = "no-number"


@dataclass(frozen=True, eq=False)
class Case:
    """One call of a function, or the same call with several seeds."""

    function: str
    arguments: tuple[Any, ...]
    words: Words
    """The situation: ``Both wheels roll 30 mm``."""
    kind: str = ""
    """What the lesson's own checks tell cases apart by."""
    tolerance: float | Array = 1e-6
    """How far features may be from the reference's."""
    seeds: tuple[int, ...] = ()
    """Seeds of the generator that is the last argument, one a call; empty is no generator."""
    offered: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    """Functions that the student's may call."""
    begin: Callable[[], None] = lambda: None
    """Called before the student's function: offered functions may keep what they are asked."""
    on_error: str = ""
    """The cause that is named if the function raises here; empty is that of any error."""
    play: Play | None = None
    """Calls the function often, as a filter does, instead of once."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """A case with the answers of each call."""

    case: Case
    answers: tuple[Answer, ...]

    @property
    def result(self) -> Any:
        """What the first call returned."""
        return self.answers[0].result


@dataclass(frozen=True, eq=False)
class Sign:
    """A cause that shows by itself in an outcome."""

    cause: str
    outcome: Outcome
    apart: bool = False
    """Whether features do not show it: it is named beside whatever else explains them."""
    note: Words | None = None
    """What shows it, where the features do not."""
    weak: bool = False
    """Whether it can be a consequence: a slip in a line that explains all goes first."""


Variant = Callable[[Case, frozenset[str]], Array]
"""The features that the reference with some mistakes has in a case."""


@dataclass(frozen=True)
class Hypothesis:
    """A wrong thought, as a mistake in the reference."""

    mistake: str
    """As the lesson's variant of the reference knows it."""
    cause: str
    excludes: frozenset[str] = frozenset()
    """Mistakes that cannot be made at the same time."""
    kind: str = ""
    """The kind of cases that show it best; empty is the first that fails."""
    broad: bool = False
    """Whether others look alike: a slip in a line that explains all goes first."""


@dataclass(frozen=True, eq=False)
class Checks:
    """All that a lesson's ``checks.py`` brings."""

    functions: tuple[str, ...]
    cases: Callable[[int], Sequence[Case]]
    """A seed to the cases, the simplest first."""
    features: Callable[[Outcome], Array]
    """What is compared of an outcome. Raises FormError if the result has another form."""
    expected: Variant
    rough: Callable[[Case, frozenset[str]], tuple[Array, Array]] | None = None
    """Features with mistakes by far fewer samples, and how far what is given may be from them:
    most mistakes are excluded by those."""
    hypotheses: tuple[Hypothesis, ...] = ()
    signs: Callable[[Sequence[Outcome]], Iterable[Sign]] = lambda _: ()
    show: Callable[[Case, Array], str] = lambda _case, features: numbers(features)
    """Features in words."""
    picture: Callable[[Outcome, Array, Array], str] | None = None
    """An outcome with the expected and the given features as SVG."""
    situation: Callable[[Case], Mapping[str, float]] | None = None
    """The pose to put the dashboard's robot at: x, y, theta; maybe guess_x and so on."""


def by_mistake(mistakes: frozenset[str], choices: Mapping[str, Chosen], usual: Chosen) -> Chosen:
    """Return the choice of the first mistake that has one; the usual one without."""
    return next((value for name, value in choices.items() if name in mistakes), usual)


def numbers(values: Array) -> str:
    """Return a few numbers in words."""
    flat = values.ravel()
    text = ", ".join(f"{value:.4g}" for value in flat[:6])
    return f"{text}, ..." if flat.size > 6 else text
