"""Reads YAML, which other people's tools wrote: a map, a lens, what a bag holds."""

from __future__ import annotations

import re
from typing import Any

import yaml

DEEPEST = 50
"""Most lists and tables in brackets within each other; files of tools need three. At each bracket
the reader looks at all that are open, so that a few thousand would take seconds."""

_OPENED = {"[": 1, "{": 1, "]": -1, "}": -1}


def parse_yaml(text: str | bytes, loader: Any = yaml.BaseLoader) -> Any:
    """Return the content of a YAML text.

    Args:
        text: the whole text, of one document.
        loader: ``BaseLoader`` keeps values as text, so that no tag can make it construct an object.

    Raises:
        yaml.YAMLError: it is no YAML, or nested too deeply.
        ValueError, RecursionError: it is no YAML either.
    """
    written = text if isinstance(text, str) else text.decode("latin-1")
    depth = 0
    for bracket in re.finditer(r"[][{}]", written):
        depth = max(depth + _OPENED[bracket[0]], 0)
        if depth > DEEPEST:
            problem = f"nested too deeply; valid are up to {DEEPEST} lists and tables in each other"
            raise yaml.MarkedYAMLError(problem=problem)
    return yaml.load(text, loader)
