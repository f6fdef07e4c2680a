"""``brickpose doctor``: runs all checks one after another, and prints the verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

from app.command_parser import CommandParser
from app.console import say
from app.engine.plugging import models_of, plug_in, plugged
from app.feature_search import OURS, FeatureError, Features
from app.page.run_options import add_serving
from app.settings.config import MAPS, Config, require_free
from app.tools.doctor.computer import check_computer
from app.tools.doctor.finding import PROBLEM, WARNING, Finding, ok, problem
from robot.errors import BrickPoseError
from robot.fields.field_loading import load_field


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
    for feature in features.active:
        if (package := features.packages.get(feature.name, OURS)) != OURS:
            yield ok(f"{feature.name}, of the package {package}: {feature.about}")
    robots = (f"{kind.name} ({kind.about})" for kind in plugged().robots.values())
    yield ok(f"Robots: {', '.join(robots)}")
    yield from (problem(failure) for failure in features.failures)
    yield from _check_start(config, features)
    yield from features.findings(config)


def _check_start(config: Config, features: Features) -> Iterator[Finding]:
    """Check what features add to the command line, to files of settings and to the models."""
    parser = CommandParser()
    parser.features = features

    def make_models() -> None:
        for failure in models_of(config, load_field(config.map, MAPS))[-1].problems.values():
            raise FeatureError(str(failure))

    checks: tuple[Callable[[], object], ...] = (
        lambda: add_serving(parser),
        lambda: require_free(features.settings),
        lambda: features.guests(config),
        make_models,
    )
    for check in checks:
        try:
            check()
        except BrickPoseError as error:
            yield problem(str(error))


def _verdict(levels: list[str]) -> str:
    problems, warnings = levels.count(PROBLEM), levels.count(WARNING)
    if problems:
        return f"{_number(problems, PROBLEM)} to solve, {_number(warnings, WARNING)}"
    return f"No problem, {_number(warnings, WARNING)}"


def _number(count: int, noun: str) -> str:
    return f"{count or 'no'} {noun}{'' if count == 1 else 's'}"
