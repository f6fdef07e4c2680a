"""The result of a benchmark, and its formats."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Result:
    """Our figure, and those of peers for the same work in the same run."""

    unit: str
    brickpose: float
    peer: dict[str, float] = field(default_factory=dict)
    more: dict[str, float] = field(default_factory=dict)
    """Other figures of the same run, with their unit in the name."""

    def to_json(self) -> dict[str, Any]:
        """Return the result as ``brickpose bench --json`` writes it."""
        ratio = {name: value / self.brickpose for name, value in self.peer.items()}
        return {
            "unit": self.unit,
            "brickpose": self.brickpose,
            "peer": self.peer,
            "ratio": ratio,
            "more": self.more,
        }

    def lines(self, name: str) -> list[str]:
        """Return the result as lines of text."""
        lines = [f"{name}: {self.brickpose:.3g} {self.unit}"]
        for peer, value in self.peer.items():
            lines.append(f"  {peer}: {value:.3g} {self.unit} ({value / self.brickpose:.2g} x)")
        lines += [f"  {more}: {value:.3g}" for more, value in self.more.items()]
        return lines
