"""What ``brickpose doctor`` checks of topics: those that features add."""

from __future__ import annotations

from collections.abc import Iterator

from app.features.ros.topics import topic_failures
from app.settings.config import Config
from app.tools.doctor.finding import Finding, problem


def check_topics(_config: Config) -> Iterator[Finding]:
    """Name the features whose topics cannot be used."""
    yield from (problem(failure) for failure in topic_failures())
