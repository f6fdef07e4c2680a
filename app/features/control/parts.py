"""PartsWriter and PartsReader: snapshots as bytes; what the one before had too is a number.

Fifty times a second a snapshot goes from one process to another. Most of it has not changed since
the last one: the picture and its scan, the cloud, the scanner with its tables, the sensor model.
Such a part is sent once, and the two ends know it by a number for as long as snapshots have it.
So what was one object is one object at the other end, too.

All other objects are taken apart by a function for their class, which is looked up in C: to ask one
function of every object takes longer than to write it.
"""

from __future__ import annotations

import io
import math
import pickle
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.features.control.shared_ring import SharedRing

SMALLEST = 256
"""An array of fewer bytes is sent again: a number would save nothing."""

LARGE = 32 * 1024
"""An array of so many bytes goes through the ring, if there is one."""

Number = int
Reducer = Callable[[Any], Any]
"""Returns of an object how it is made: a function and its arguments, as ``__reduce__`` does."""


@dataclass(slots=True, eq=False)
class _Part:
    """An object that both ends have."""

    value: object
    inside: set[Number] = field(default_factory=set)
    """Parts within it: they are kept as long as it is."""


class _Table:
    """The parts that one end has, by their numbers."""

    def __init__(self, shared: Sequence[object] = ()) -> None:
        self.parts: dict[Number, _Part] = {-1 - n: _Part(each) for n, each in enumerate(shared)}
        """What both ends had before the first message has negative numbers, and stays."""
        self.used: set[Number] = set()
        """Those of the message at hand."""

    def drop_unused(self) -> None:
        """Keep the parts of the message at hand, with what is within them, and no others."""
        kept: set[Number] = set()
        waiting = [*self.used, *(number for number in self.parts if number < 0)]
        while waiting:
            number = waiting.pop()
            if number not in kept:
                kept.add(number)
                waiting += self.parts[number].inside
        self.parts = {number: self.parts[number] for number in kept}
        self.used = set()


class PartsWriter:
    """Turns values into bytes for one reader, which must get all of them in their order."""

    def __init__(
        self,
        kinds: Iterable[type],
        ring: SharedRing | None = None,
        shared: Sequence[object] = (),
    ) -> None:
        """Objects of these classes, and large arrays, are parts; nobody may change them.

        So are those of a class that says ``is_part = True``. What has a method ``elsewhere`` is
        made by what this returns, a function and its arguments. The reader has the same ring, and
        the same ``shared`` parts, which are never sent: as a fork has those of before it.
        """
        self._kinds = frozenset(kinds)
        self._ring = ring
        self._table = _Table(shared)
        self._numbers = {id(part.value): n for n, part in self._table.parts.items()}
        self._next = 0
        self._reducers = _Reducers(self._reducer)
        self._around: set[Number] = set()
        """The parts of what is being written."""
        self._whole: object = None
        """The part that is being written itself, and not as a number."""

    def write(self, value: object) -> bytes:
        """Return a value as bytes.

        Raises:
            Exception: something in it cannot be pickled; later values can be written still.
        """
        before = self._table.parts.copy(), self._numbers.copy()
        try:
            written = self._pickled(value, self._table.used)
        except BaseException:
            self._table.parts, self._numbers = before
            self._table.used = set()
            raise
        self._table.drop_unused()
        self._numbers = {id(part.value): number for number, part in self._table.parts.items()}
        return written

    def _pickled(self, value: object, around: set[Number], whole: object = None) -> bytes:
        outside = self._around, self._whole
        self._around, self._whole = around, whole
        file = io.BytesIO()
        pickler = pickle.Pickler(file, pickle.HIGHEST_PROTOCOL)
        pickler.dispatch_table = self._reducers
        try:
            pickler.dump(value)
        finally:
            self._around, self._whole = outside
        return file.getvalue()

    def _reducer(self, kind: type) -> Reducer:
        """Return what reduces the objects of a class."""
        if kind is np.ndarray:
            return self._array
        alone = _alone(kind)
        if kind not in self._kinds and not getattr(kind, "is_part", False):
            return alone
        return lambda value: alone(value) if value is self._whole else self._part(value)

    def _array(self, value: NDArray[Any]) -> Any:
        plain = value.flags.c_contiguous and value.dtype.kind in "bfiu"
        if value.nbytes < SMALLEST:
            return (
                (_array, (value.tobytes(), value.dtype.str, value.shape))
                if plain
                else _usual(value)
            )
        if not plain:
            return _usual(value) if value is self._whole else self._part(value)
        known = self._known(value)
        if known is not None:
            return _part, (known,)
        number = self._new(value, set())
        placed = self._ring.put(value) if self._ring and value.nbytes >= LARGE else None
        data = value.tobytes() if placed is None else placed
        return _array_part, (number, data, value.dtype.str, value.shape)

    def _part(self, value: object) -> Any:
        known = self._known(value)
        if known is not None:
            return _part, (known,)
        inside: set[Number] = set()
        content = self._pickled(value, inside, whole=value)
        return _part, (self._new(value, inside), content)

    def _known(self, value: object) -> Number | None:
        number = self._numbers.get(id(value))
        if number is not None:
            self._around.add(number)
        return number

    def _new(self, value: object, inside: set[Number]) -> Number:
        number = self._next
        self._next += 1
        self._table.parts[number] = _Part(value, inside)
        self._numbers[id(value)] = number
        self._around.add(number)
        return number


class _Reducers(dict[type, Reducer]):
    """Reducers by class, each looked up once, as a pickler asks for them."""

    def __init__(self, find: Callable[[type], Reducer]) -> None:
        super().__init__()
        self._find = find

    def __missing__(self, kind: type) -> Reducer:
        if issubclass(kind, type):
            raise KeyError(kind)  # a class: it is pickled by its name
        self[kind] = reducer = self._find(kind)
        return reducer


def _alone(kind: type) -> Reducer:
    """Return what reduces an object of a class that is no part."""
    elsewhere = getattr(kind, "elsewhere", None)
    if elsewhere is not None:
        return lambda value: elsewhere(value) or _usual(value)
    if getattr(kind.__getstate__, "__module__", None) != "dataclasses":
        return _usual
    # With slots, and frozen: Python asks for the names of the fields at each object again.
    values = attrgetter("__class__", *(each.name for each in fields(kind)))
    return lambda value: (_made, values(value))


def _usual(value: Any) -> Any:
    return value.__reduce_ex__(pickle.HIGHEST_PROTOCOL)


def _made(kind: type, *values: object) -> Any:
    """Return an object of a frozen dataclass with slots."""
    made: object = object.__new__(kind)
    for put, value in zip(_setters(kind), values, strict=True):
        put(made, value)
    return made


@cache
def _setters(kind: Any) -> tuple[Callable[[object, object], None], ...]:
    return tuple(getattr(kind, each.name).__set__ for each in fields(kind))


def _array(content: bytes | NDArray[np.uint8], form: str, shape: tuple[int, ...]) -> Any:
    """Return a read-only array."""
    array = np.frombuffer(content, form).reshape(shape)
    array.setflags(write=False)
    return array


def _part(number: Number, content: bytes | None = None) -> Any:
    """Stand for ``_Unpickler.part``, which alone has the parts."""
    raise pickle.UnpicklingError("a part is read by PartsReader only")


def _array_part(number: Number, content: bytes | int, form: str, shape: tuple[int, ...]) -> Any:
    """Stand for ``_Unpickler.array_part``: ``content``, or where in the ring it is."""
    raise pickle.UnpicklingError("a part is read by PartsReader only")


class PartsReader:
    """Turns bytes of one writer into the values that they were."""

    def __init__(self, ring: SharedRing | None = None, shared: Sequence[object] = ()) -> None:
        """``ring`` and ``shared`` are the writer's."""
        self._table = _Table(shared)
        self._ring = ring
        self._read = 0
        """Up to where the ring is read."""
        self._by_name: dict[tuple[str, str], Any] = {
            (__name__, _part.__name__): self._part,
            (__name__, _array_part.__name__): self._array_part,
        }
        """Classes and functions by module and name."""
        self._around = self._table.used
        """The parts of what is being read."""

    def read(self, written: bytes) -> Any:
        """Return the value."""
        if self._ring is not None:
            self._ring.free(self._read)
        value = self._unpickled(written, self._table.used)
        self._table.drop_unused()
        return value

    def _unpickled(self, written: bytes, around: set[Number]) -> Any:
        outside, self._around = self._around, around
        try:
            return _Unpickler(io.BytesIO(written), self._by_name).load()
        finally:
            self._around = outside

    def _part(self, number: Number, content: bytes | None = None) -> Any:
        """Return the part that a number stands for, after reading it if it is new."""
        self._around.add(number)
        if content is None:
            return self._table.parts[number].value
        inside: set[Number] = set()
        value = self._unpickled(content, inside)
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
        self._table.parts[number] = _Part(value, inside)
        return value

    def _array_part(
        self, number: Number, content: bytes | int, form: str, shape: tuple[int, ...]
    ) -> Any:
        self._around.add(number)
        if isinstance(content, int):
            assert self._ring is not None  # the writer has put it there
            size = math.prod(shape) * np.dtype(form).itemsize
            value = _array(self._ring.take(content, size), form, shape)
            self._read = content + size
        else:
            value = _array(content, form, shape)
        self._table.parts[number] = _Part(value)
        return value


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, by_name: dict[tuple[str, str], Any]) -> None:
        super().__init__(file)
        self._by_name = by_name

    def find_class(self, module: str, name: str) -> Any:
        """Return a class or a function by its name, looked up once."""
        known = self._by_name.get((module, name))
        if known is None:
            known = self._by_name[module, name] = super().find_class(module, name)
        return known
