"""A client that may drive."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

OWN = ("127.0.0.1", "::1")
"""Addresses of this machine, which say nothing about the client."""

_numbers = itertools.count(1)


@dataclass(eq=False)
class Driver:
    """A client that may drive; two clients are equal only if they are the same object."""

    name: str
    """The name that others see, such as ``ROS 2``."""

    @classmethod
    def numbered(cls, kind: str, address: str | None = None) -> Driver:
        """Return a new client with a number in its name; ``kind`` is such as ``page {number}``."""
        name = kind.format(number=next(_numbers))
        return cls(f"{name} at {address}" if address and address not in OWN else name)
