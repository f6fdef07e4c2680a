"""SharedRing: large arrays go from one process to its fork, or back, without a pipe.

A pipe copies a picture twice, and wakes both ends for each of its pieces. Here it is written once
and read once. Who writes never waits: where there is no room, the pipe takes the array after all.
The memory has no name, so it ends with the last process that has it, however that ends.
"""

from __future__ import annotations

import mmap

import numpy as np
from numpy.typing import NDArray

SIZE = 8 * 2**20
"""Room [bytes]; only what is used is memory: two pictures, while the reader keeps up."""
HEAD = 64


class SharedRing:
    """Bytes in the order in which they were put; one thread writes, one of another process reads.

    Positions count all bytes since the start. The one number that both ends share is up to where
    the reader has read; an old one only leaves the writer less room.
    """

    def __init__(self, size: int = SIZE) -> None:
        """Make a ring; a process that is forked afterwards has it, too."""
        memory = mmap.mmap(-1, HEAD + size)
        self._freed = np.frombuffer(memory, np.uint64, 1)
        self._bytes = np.frombuffer(memory, np.uint8, offset=HEAD)
        self._begun = self._end = 0

    def put(self, array: NDArray[np.generic]) -> int | None:
        """Write an array that lies in one piece; return its position, None without room for it."""
        size = len(self._bytes)
        freed = max(int(self._freed[0]), self._begun)
        if freed == self._end:  # all is read: the first pages are in the processor's cache still
            self._begun = self._end = freed = _rounded_up(freed, size)
        begin = self._end
        if begin % size + array.nbytes > size:
            begin = _rounded_up(begin, size)
        end = begin + array.nbytes
        if end - freed > size:
            return None
        place = begin % size
        self._bytes[place : place + array.nbytes] = array.reshape(-1).view(np.uint8)
        self._end = end
        return begin

    def take(self, position: int, count: int) -> NDArray[np.uint8]:
        """Return a copy of what was put at a position."""
        place = position % len(self._bytes)
        return self._bytes[place : place + count].copy()

    def free(self, position: int) -> None:
        """Tell the writer that all before a position is read."""
        self._freed[0] = position


def _rounded_up(position: int, size: int) -> int:
    return -(-position // size) * size
