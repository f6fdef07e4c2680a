"""Stores the state of a run, with its random generators, so that it can continue from there.

Objects that never change are referenced, not copied. Large arrays that are the same in several
checkpoints are stored once.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakValueDictionary

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.errors import BrickPoseError
from robot.localization.filter_by_hand import HandStep
from robot.localization.models.entry_field import EntryField
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan, LineScanner

IMMUTABLE = (
    DifferentialDrive, EntryField, HandStep, LineScanner, RayEvidence, RobotSpec, Scan, ScanMatcher,
)  # fmt: skip
"""Types of frozen objects that are referenced. A feature's type says so itself: ``referenced``."""

LEFT_OUT = (LineScan,)
"""Types that are not stored. A line scan holds a picture; the next picture gives a new scan."""

MODELS = "robot.localization.models."
"""Package of the program's own models: they are frozen, too."""

LARGE = 1 << 15
"""An array of at least this size [bytes] is stored once for all checkpoints that have it."""


class CheckpointError(BrickPoseError, TypeError):
    """The state cannot be stored: some object, for example in a user's model, cannot be copied."""


class Block:
    """The bytes of an array."""

    __slots__ = ("__weakref__", "content")

    def __init__(self, content: bytes) -> None:
        self.content = content


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A stored state, which can be restored any number of times."""

    content: bytes = field(repr=False)
    blocks: tuple[Block, ...] = field(repr=False)
    shared: tuple[object, ...] = field(repr=False)
    """Objects that are referenced, not copied."""

    @property
    def size(self) -> int:
        """Size [bytes]; it includes blocks that other checkpoints share."""
        return len(self.content) + sum(len(block.content) for block in self.blocks)

    def restore(self) -> Any:
        """Return a new copy of the stored state."""
        buffers = [bytearray(block.content) for block in self.blocks]
        return _Unpickler(self, buffers).load()


class CheckpointWriter:
    """Makes checkpoints."""

    def __init__(self, unchanging: Iterable[object]) -> None:
        """``unchanging`` are objects to reference, besides those of immutable types."""
        self._unchanging = tuple(unchanging)
        self._ids = frozenset(map(id, self._unchanging))
        self._blocks: WeakValueDictionary[bytes, Block] = WeakValueDictionary()

    def keep(self, state: object) -> Checkpoint:
        """Store a state as it is now.

        Raises:
            CheckpointError: some object cannot be copied; the message names it.
        """
        content = io.BytesIO()
        blocks: list[Block] = []
        pickler = _Pickler(content, self._ids, lambda buffer: self._take(buffer, blocks))
        try:
            pickler.dump(state)
        # A user's own model may raise anything when it is copied.
        except Exception as error:
            raise CheckpointError(f"the state cannot be kept: {error}") from error
        return Checkpoint(content.getvalue(), tuple(blocks), tuple(pickler.shared))

    def _take(self, buffer: pickle.PickleBuffer, blocks: list[Block]) -> bool:
        """Return whether a small array is stored in the content; store a large one as a block."""
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
        """Return the number of a referenced object, -1 to leave it out, or None to copy it."""
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
        """Return the object with this number; None for one that was left out."""
        return None if pid < 0 else self._shared[pid]


def _is_immutable(obj: object) -> bool:
    kind = type(obj)
    model = kind is not type and kind.__module__.startswith(MODELS)
    return kind is Checkpoint or kind in IMMUTABLE or model or hasattr(kind, "referenced")
