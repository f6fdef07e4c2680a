"""``brickpose doctor``: runs all checks one after another, and prints the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from app.console import say
from app.engine.plugging import plug_in
from app.feature_search import Features
from app.settings.config import Config
from app.tools.doctor.computer import check_computer
from app.tools.doctor.finding import PROBLEM, WARNING, Finding, ok, problem


def doctor(config: Config, features: Features = Features()) -> int:
    """Check the machine, and what features say has to be checked; return 1 on a problem, else 0."""
    result = []
    features = plug_in(features)
    for finding in chain(check_computer(config), check_features(config, features)):
        say(str(finding))
        result.append(finding)
    say(_verdict([each.level for each in result]))
    return int(any(item.level == PROBLEM for item in result))


def check_features(config: Config, features: Features) -> Iterator[Finding]:
    """Say which features take part, and check what these say has to be checked."""
    names = ", ".join(feature.name for feature in features.active) or "none"
    left_out = f"; left out: {', '.join(features.left_out)}" if features.left_out else ""
    yield ok(f"Features: {names}{left_out}")
    yield from (problem(failure) for failure in features.failures)
    yield from features.findings(config)


def _verdict(levels: list[str]) -> str:
    problems, warnings = levels.count(PROBLEM), levels.count(WARNING)
    if problems:
        return f"{_number(problems, PROBLEM)} to solve, {_number(warnings, WARNING)}"
    return f"No problem, {_number(warnings, WARNING)}"


def _number(count: int, noun: str) -> str:
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"
