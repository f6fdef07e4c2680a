"""Which physics engines a test can use on this computer."""

from __future__ import annotations

import pytest

from robot.errors import PackageError
from sim.engines import choose_engine

ENGINES = ("mujoco", "bullet")
"""Ours, by name, in the order in which ``auto`` tries them."""


def require_engine(name: str = "auto") -> None:
    """Skip the test if a physics engine, or any, is not installed."""
    try:
        choose_engine(name)
    except PackageError as error:
        pytest.skip(str(error))
