"""The checkpoints of one replay: many if they are small, fewer if they are large."""

from __future__ import annotations

from bisect import bisect_left, insort
from dataclasses import dataclass, field

from app.engine.checkpoint import Checkpoint

MOST_BYTES = 100_000_000
"""Largest size of all checkpoints together; beyond it, every second one is dropped."""

SPACING_NS = 2_000_000_000
"""Initial interval between two checkpoints [ns]."""


@dataclass(frozen=True, slots=True, order=True)
class StoredCheckpoint:
    """A checkpoint, taken after the tick at a time."""

    log_ns: int
    checkpoint: Checkpoint = field(compare=False)


class Checkpoints:
    """Checkpoints by time; all belong to the same settings."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: list[StoredCheckpoint] = []
        self._spacing_ns = SPACING_NS

    def __len__(self) -> int:
        return len(self._kept)

    @property
    def size(self) -> int:
        """Size of all checkpoints [bytes]; a block that several of them share counts once."""
        blocks = {id(b): len(b.content) for each in self._kept for b in each.checkpoint.blocks}
        return sum(len(item.checkpoint.content) for item in self._kept) + sum(blocks.values())

    def due(self, log_ns: int) -> bool:
        """Whether a checkpoint is due at a time, because none is near it."""
        after = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        near = self._kept[max(after - 1, 0) : after + 1]
        return all(abs(each.log_ns - log_ns) >= self._spacing_ns for each in near)

    def add(self, log_ns: int, checkpoint: Checkpoint) -> None:
        """Store a checkpoint; drop every second one if they are too large together."""
        insort(self._kept, StoredCheckpoint(log_ns, checkpoint))
        while len(self._kept) > 1 and self.size > self._most_bytes:
            del self._kept[1::2]
            self._spacing_ns *= 2

    def before(self, log_ns: int) -> StoredCheckpoint | None:
        """The last checkpoint before a time; None if there is none."""
        result = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        return self._kept[result - 1] if result else None

    def clear(self) -> None:
        """Drop all checkpoints, because the settings changed."""
        self._kept.clear()
        self._spacing_ns = SPACING_NS
