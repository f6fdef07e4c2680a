"""Numbers in the entries of a lens's file, which are all text."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from robot.geometry import Array


def whole(content: dict[str, Any], key: str) -> int:
    """Return the whole number under a key.

    Raises:
        KeyError: there is no such key.
        ValueError: it is no whole number.
    """
    text = content[key]
    if not (isinstance(text, str) and re.fullmatch(r"\d{1,9}", text)):
        raise ValueError(f"{key} is {shown(text)}; valid is a whole number")
    return int(text)


def number(text: Any) -> float:
    """Return a text as a number; nan if it is not a number."""
    try:
        return float(text) if isinstance(text, str) else math.nan
    except ValueError:
        return math.nan


def numbers(values: Any) -> Array | None:
    """Return a list of texts as finite numbers (n,); None if it is none of such."""
    if not isinstance(values, list):
        return None
    result = np.array([number(text) for text in values], np.float64)
    return result if np.isfinite(result).all() else None


def matrix(values: Any, key: str, where: str = "") -> Array:
    """Return a list of nine numbers, row by row, as a matrix (3, 3).

    Raises:
        ValueError: it is none; names the key.
    """
    result = numbers(values)
    if result is None or len(result) != 9:
        raise ValueError(f"{key} needs a list of 9 finite numbers{where}")
    return result.reshape(3, 3)


def coefficients(values: Any, key: str, where: str = "") -> Array:
    """Return a list of numbers (n,).

    Raises:
        ValueError: it is none; names the key.
    """
    result = numbers(values)
    if result is None:
        raise ValueError(f"{key} needs a list of finite numbers{where}")
    return result


def shown(value: Any) -> str:
    """Return a value for people; lists by their kind, as aliases can make them endless."""
    return repr(value)[:80] if isinstance(value, str) else type(value).__name__
