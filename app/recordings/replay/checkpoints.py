"""The checkpoints of one replay: many where that costs little, fewer where they are large."""

from __future__ import annotations

from bisect import bisect_left, insort
from dataclasses import dataclass, field

from app.engine.checkpoint import Checkpoint

MOST_BYTES = 100_000_000
"""Together; beyond it every second one is given up."""

SPACING_NS = 2_000_000_000
"""From one to the next, at first."""


@dataclass(frozen=True, slots=True, order=True)
class StoredCheckpoint:
    """A checkpoint after the tick of a time."""

    log_ns: int
    checkpoint: Checkpoint = field(compare=False)


class Checkpoints:
    """By time; all are of the same settings."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: list[StoredCheckpoint] = []
        self._spacing_ns = SPACING_NS

    def __len__(self) -> int:
        return len(self._kept)

    @property
    def size(self) -> int:
        """All together [bytes]; a block that several share counts once."""
        blocks = {id(b): len(b.content) for each in self._kept for b in each.checkpoint.blocks}
        return sum(len(item.checkpoint.content) for item in self._kept) + sum(blocks.values())

    def due(self, log_ns: int) -> bool:
        """Whether there should be one at a time, as there is none near it."""
        after = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        near = self._kept[max(after - 1, 0) : after + 1]
        return all(abs(each.log_ns - log_ns) >= self._spacing_ns for each in near)

    def add(self, log_ns: int, checkpoint: Checkpoint) -> None:
        """Keep one more."""
        insort(self._kept, StoredCheckpoint(log_ns, checkpoint))
        while len(self._kept) > 1 and self.size > self._most_bytes:
            del self._kept[1::2]
            self._spacing_ns *= 2

    def before(self, log_ns: int) -> StoredCheckpoint | None:
        """The last one before a time."""
        result = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        return self._kept[result - 1] if result else None

    def clear(self) -> None:
        """Give all up: other settings hold."""
        self._kept.clear()
        self._spacing_ns = SPACING_NS
