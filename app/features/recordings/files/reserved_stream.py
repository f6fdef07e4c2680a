"""A stream into a file with reserved space: it can still be finished when the disk is full."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a full disk, of a used-up quota, and of the largest size of a file."""


class ReservedStream:
    """A file that is cut off after its last complete part if a write fails.

    Space on the disk is kept beside it. When the disk is full, a write that has begun goes on in
    that space, and ``full`` tells that the file has to be finished now.
    """

    def __init__(self, path: Path) -> None:
        """Make the file.

        Raises:
            FileExistsError: it exists.
            OSError: it cannot be made.
        """
        self._file = path.open("xb", buffering=0)
        self._reserve = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115 - until release
        self.good = 0
        """Length of the complete part [bytes]."""
        self.full: OSError | None = None
        """Why the rest of the disk is now used; None while there is space."""
        self.whole = True
        """Whether all that was to be written is in the file."""

    def reserve(self, size: int) -> None:
        """Keep this much space [bytes] if the disk has it; else what was kept before."""
        if self.full is None and hasattr(os, "posix_fallocate"):
            with suppress(OSError):
                os.posix_fallocate(self._reserve.fileno(), 0, size)

    @contextmanager
    def noticing_full(self) -> Iterator[None]:
        """Take note if writing something else in the block meets a full disk; the error goes on."""
        try:
            yield
        except OSError as error:
            if error.errno in FULL:
                self.full = error
            raise

    def release(self) -> None:
        """Give the kept space free, for what has to be written last."""
        self._reserve.close()

    def write(self, data: bytes) -> int:
        """Write all of the data.

        Raises:
            OSError: it cannot be written; the file is cut off after its last complete part.
        """
        rest = memoryview(data)
        try:
            while rest:
                try:
                    rest = rest[self._file.write(rest) :]
                except OSError as error:
                    if error.errno not in FULL or self.full is not None:
                        raise
                    self.full = error
                    self.release()
        except OSError:
            self.whole = False
            os.ftruncate(self._file.fileno(), self.good)
            self._file.seek(self.good)
            raise
        return len(data)

    def tell(self) -> int:
        """Return the length that is written [bytes]."""
        return self._file.tell()

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    def mark(self) -> None:
        """Take note that all that is written is complete."""
        self.good = self._file.tell()

    @property
    def closed(self) -> bool:
        """Whether the file is closed."""
        return self._file.closed

    def close(self) -> None:
        """Close the file, and give the kept space free."""
        self.release()
        self._file.close()
