"""PartsWriter and PartsReader: snapshots as bytes; what the one before had too is a number.

Fifty times a second a snapshot goes from one process to another. Most of it has not changed since
the last one: the picture and its scan, the cloud, the scanner with its tables, the sensor model.
Such a part is sent once, and the two ends know it by a number for as long as snapshots have it.
So what was one object is one object at the other end, too.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

SMALLEST = 256
"""An array of fewer bytes is sent again: a number would save nothing."""

Number = int
Told = tuple[Number] | tuple[Number, bytes]
"""The number of a part, and what it is, if the other end does not have it."""


@dataclass(slots=True, eq=False)
class _Part:
    """An object that both ends have."""

    value: object
    inside: set[Number] = field(default_factory=set)
    """Parts within it: they are kept as long as it is."""


class _Table:
    """The parts that one end has, by their numbers."""

    def __init__(self) -> None:
        self.parts: dict[Number, _Part] = {}
        self.used: set[Number] = set()
        """Those of the message at hand."""

    def drop_unused(self) -> None:
        """Keep the parts of the message at hand, with what is within them, and no others."""
        kept: set[Number] = set()
        waiting = list(self.used)
        while waiting:
            number = waiting.pop()
            if number not in kept:
                kept.add(number)
                waiting += self.parts[number].inside
        self.parts = {number: self.parts[number] for number in kept}
        self.used = set()


class PartsWriter:
    """Turns values into bytes for one reader, which must get all of them in their order."""

    def __init__(self, kinds: Iterable[type]) -> None:
        """Objects of these classes, and large arrays, are parts; nobody may change them.

        So are those of a class that says ``is_part = True``. What has a method ``elsewhere`` is
        made by what this returns, a function and its arguments.
        """
        self._kinds = frozenset(kinds)
        self._table = _Table()
        self._numbers: dict[int, Number] = {}
        self._next = 0

    def write(self, value: object) -> bytes:
        """Return a value as bytes.

        Raises:
            Exception: something in it cannot be pickled; later values can be written still.
        """
        before = self._table.parts.copy(), self._numbers.copy()
        try:
            written = _Pickler.pickled(self, value, self._table.used)
        except BaseException:
            self._table.parts, self._numbers = before
            self._table.used = set()
            raise
        self._table.drop_unused()
        self._numbers = {id(part.value): number for number, part in self._table.parts.items()}
        return written

    def part(self, value: object, around: set[Number]) -> Told | None:
        """Return what stands for an object: nothing, unless it is a part."""
        if type(value) is np.ndarray:
            if value.nbytes < SMALLEST:
                return None
        elif type(value) not in self._kinds and not getattr(type(value), "is_part", False):
            return None
        known = self._numbers.get(id(value))
        if known is not None:
            around.add(known)
            return (known,)
        number = self._next
        self._next += 1
        inside: set[Number] = set()
        content = _Pickler.pickled(self, value, inside, whole=value)
        self._table.parts[number] = _Part(value, inside)
        self._numbers[id(value)] = number
        around.add(number)
        return number, content


class _Pickler(pickle.Pickler):
    """Pickles one value, and numbers for the parts within it."""

    def __init__(self, file: io.BytesIO, writer: PartsWriter, around: set[Number]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._writer = writer
        self._around = around
        self._whole: object = None

    @classmethod
    def pickled(
        cls, writer: PartsWriter, value: object, around: set[Number], whole: object = None
    ) -> bytes:
        """Return a value as bytes; a part itself is ``whole``, and not a number."""
        file = io.BytesIO()
        pickler = cls(file, writer, around)
        pickler._whole = whole
        pickler.dump(value)
        return file.getvalue()

    def reducer_override(self, obj: Any) -> Any:
        """Return how the other end gets an object: as a part, as it says itself, or as usual.

        ``persistent_id`` would do for parts; but it is asked of each number and each word as well.
        """
        if obj is not self._whole:
            part = self._writer.part(obj, self._around)
            if part is not None:
                return _part, part
        elsewhere = getattr(type(obj), "elsewhere", None)
        made = None if elsewhere is None else elsewhere(obj)
        return NotImplemented if made is None else made


def _part(number: Number, content: bytes | None = None) -> Any:
    """Stand for ``_Unpickler.part``, which alone has the parts."""
    raise pickle.UnpicklingError("a part is read by PartsReader only")


class PartsReader:
    """Turns bytes of one writer into the values that they were."""

    def __init__(self) -> None:
        self._table = _Table()

    def read(self, written: bytes) -> Any:
        """Return the value."""
        value = _Unpickler.unpickled(self._table, written, self._table.used)
        self._table.drop_unused()
        return value


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, table: _Table, around: set[Number]) -> None:
        super().__init__(file)
        self._table = table
        self._around = around

    @classmethod
    def unpickled(cls, table: _Table, written: bytes, around: set[Number]) -> Any:
        return cls(io.BytesIO(written), table, around).load()

    def find_class(self, module: str, name: str) -> Any:
        """Return a class or a function by its name; for ``_part`` what has the parts."""
        if (module, name) == (_part.__module__, _part.__name__):
            return self.part
        return super().find_class(module, name)

    def part(self, number: Number, content: bytes | None = None) -> Any:
        """Return the part that a number stands for, after reading it if it is new."""
        self._around.add(number)
        if content is None:
            return self._table.parts[number].value
        inside: set[Number] = set()
        value = self.unpickled(self._table, content, inside)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        self._table.parts[number] = _Part(value, inside)
        return value
