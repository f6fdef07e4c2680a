"""A client that may drive."""

from __future__ import annotations

import itertools
from collections.abc import Hashable
from dataclasses import dataclass, field

OWN = ("127.0.0.1", "::1")
"""Addresses of this machine, which say nothing about the client."""

_numbers = itertools.count(1)


@dataclass(eq=False)
class Driver:
    """A client that may drive; two clients are equal only if they are the same object."""

    name: str
    """The name that others see, such as ``ROS 2``."""
    person: Hashable = field(default_factory=object)
    """Whose client it is: by default nobody else's. The pages of one browser are one person's."""

    @classmethod
    def numbered(cls, kind: str, address: str | None = None) -> Driver:
        """Return a new client with a number in its name; ``kind`` as ``program {number}``."""
        return cls.at(kind.format(number=next(_numbers)), address)

    @classmethod
    def at(cls, name: str, address: str | None) -> Driver:
        """Return a new client whose name says from where it comes, if that is not this machine."""
        return cls(f"{name} at {address}" if address and address not in OWN else name)
