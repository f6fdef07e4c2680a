"""Keeps the state of what runs, generators and all, so that it can go on from there again.

What never changes is referred to, and not copied. Large arrays that are the same in several
checkpoints are kept once.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakValueDictionary

from robot.driving.differential_drive import DifferentialDrive
from robot.localization.models.entry_field import EntryField
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan

IMMUTABLE = (DifferentialDrive, EntryField, RayEvidence, ScanMatcher, Scan)
"""Types of what is frozen and holds arrays that nobody writes to."""

LEFT_OUT = (LineScan,)
"""Holds a picture; the next one brings a new one."""

MODELS = "robot.localization.models."
"""The models that come with the program are frozen, too."""

LARGE = 1 << 15
"""From this size on [bytes] an array is kept once, however many checkpoints have it."""


class CheckpointError(TypeError):
    """The state cannot be kept: something in it, as in a user's own model, cannot be copied."""


class Block:
    """The bytes of an array."""

    __slots__ = ("__weakref__", "content")

    def __init__(self, content: bytes) -> None:
        self.content = content


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A state that was kept; it may be brought back any number of times."""

    content: bytes = field(repr=False)
    blocks: tuple[Block, ...] = field(repr=False)
    shared: tuple[object, ...] = field(repr=False)
    """What is referred to."""

    @property
    def size(self) -> int:
        """Bytes; blocks that other checkpoints share count here, too."""
        return len(self.content) + sum(len(block.content) for block in self.blocks)

    def restore(self) -> Any:
        """A new copy of the state, as it was."""
        buffers = [bytearray(block.content) for block in self.blocks]
        return _Unpickler(self, buffers).load()


class CheckpointWriter:
    """Makes checkpoints."""

    def __init__(self, unchanging: Iterable[object]) -> None:
        """``unchanging`` are objects that are referred to besides those of immutable types."""
        self._unchanging = tuple(unchanging)
        self._ids = frozenset(map(id, self._unchanging))
        self._blocks: WeakValueDictionary[bytes, Block] = WeakValueDictionary()

    def keep(self, state: object) -> Checkpoint:
        """Keep a state as it is now.

        Raises:
            CheckpointError: names what cannot be copied.
        """
        content = io.BytesIO()
        blocks: list[Block] = []
        pickler = _Pickler(content, self._ids, lambda buffer: self._take(buffer, blocks))
        try:
            pickler.dump(state)
        # A user's own model may do anything when it is copied.
        except Exception as error:
            raise CheckpointError(f"the state cannot be kept: {error}") from error
        return Checkpoint(content.getvalue(), tuple(blocks), tuple(pickler.shared))

    def _take(self, buffer: pickle.PickleBuffer, blocks: list[Block]) -> bool:
        """Whether an array goes with the rest, because it is small."""
        raw = buffer.raw()
        if raw.nbytes < LARGE:
            return True
        digest = hashlib.blake2b(raw, digest_size=20).digest()
        block = self._blocks.get(digest)
        if block is None:
            block = self._blocks[digest] = Block(bytes(raw))
        blocks.append(block)
        return False


class _Pickler(pickle.Pickler):
    def __init__(self, content: io.BytesIO, unchanging: frozenset[int], take: Any) -> None:
        super().__init__(content, protocol=5, buffer_callback=take)
        self.shared: list[object] = []
        self._unchanging = unchanging
        self._numbers: dict[int, int] = {}

    def persistent_id(self, obj: Any) -> int | None:
        """The number of what is referred to; None for what is copied."""
        if isinstance(obj, LEFT_OUT):
            return -1
        if id(obj) not in self._unchanging and not _is_immutable(obj):
            return None
        number = self._numbers.get(id(obj))
        if number is None:
            number = self._numbers[id(obj)] = len(self.shared)
            self.shared.append(obj)
        return number


class _Unpickler(pickle.Unpickler):
    def __init__(self, checkpoint: Checkpoint, buffers: list[bytearray]) -> None:
        super().__init__(io.BytesIO(checkpoint.content), buffers=buffers)
        self._shared = checkpoint.shared

    def persistent_load(self, pid: Any) -> object:
        """What a number refers to."""
        return None if pid < 0 else self._shared[pid]


def _is_immutable(obj: object) -> bool:
    kind = type(obj)
    return kind in IMMUTABLE or (kind is not type and kind.__module__.startswith(MODELS))
