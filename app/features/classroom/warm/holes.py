"""Fills what is free between the objects of a process of which copies will be made.

A copy shares pages until it writes to them. What it allocates would go into the gaps that freed
objects have left, all over the memory, and each copies a page for the sake of some bytes. With the
gaps taken, a copy's own objects lie together, in pages of their own.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import tempfile

ROW = re.compile(r"^\s*\d+\s+(\d+)\s+\d+\s+\d+\s+(\d+)\s*$", re.MULTILINE)
"""Of the table that Python has of its allocator: the size of blocks, and how many are free."""
SMALLEST = 16
HEAD = sys.getsizeof(b"")
OVERHEAD = 8
"""What glibc needs itself of each chunk [bytes]."""
CHUNKS = (*(1 << power for power in range(16, 10, -1)), *range(1024, 16, -16))
"""Sizes of glibc's chunks [bytes], the largest first; longer gaps have pages of their own."""


class _Heap(ctypes.Structure):
    """``struct mallinfo2`` of glibc; ``top`` is free at the heap's end [bytes]."""

    _fields_ = (*((f"other_{number}", ctypes.c_size_t) for number in range(9)),
                ("top", ctypes.c_size_t))  # fmt: skip


def fill_holes() -> list[object]:
    """Take what is free between what is taken; return the objects that hold it, to be kept.

    The C library's gaps stay taken for good, if it is glibc.
    """
    _fill_heap()
    rows = [(int(size), int(free)) for size, free in ROW.findall(_allocator_table())]
    return [[_block(size) for _ in range(free)] for size, free in rows]


def _block(size: int) -> object:
    if size <= SMALLEST:
        return object()
    return bytes(size - HEAD) if size > HEAD + 1 else float(size)


def _allocator_table() -> str:
    """Return what Python tells of its allocator; it only writes that to a process's errors."""
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file:
        errors = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            sys._debugmallocstats()
        finally:
            os.dup2(errors, 2)
            os.close(errors)
        file.seek(0)
        return file.read().decode("ascii", "replace")


def _fill_heap() -> None:
    libc = ctypes.CDLL(None)
    if not hasattr(libc, "mallinfo2"):
        return
    libc.mallinfo2.restype = _Heap
    libc.malloc.restype = libc.sbrk.restype = ctypes.c_void_p
    for chunk in CHUNKS:
        end = libc.sbrk(0) - libc.mallinfo2().top
        while (taken := libc.malloc(ctypes.c_size_t(chunk - OVERHEAD))) and taken < end:
            pass
        libc.free(ctypes.c_void_p(taken))
