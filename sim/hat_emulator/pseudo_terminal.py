"""A serial port without a wire: one end is a device that programs open, the other is ours."""

from __future__ import annotations

import os
import tty
from contextlib import suppress
from pathlib import Path

CHUNK = 4096
"""Bytes that are read at once."""


class TerminalError(OSError):
    """The serial port cannot be made under the name that was asked for."""


class PseudoTerminal:
    """Our end of it. It never waits: what nobody reads is dropped, as a board's full buffer does.

    It is raw from the start: an echo, or a line end made from another, would garble the language.
    The device stays open here as well, else our end would be an error between two programs.
    """

    def __init__(self, link: Path | None = None) -> None:
        """Make it, and a symbolic link to the device if a name is given.

        Raises:
            TerminalError: there is something else than a link under that name, or no such folder.
        """
        self._end: int | None
        self._end, self._device = os.openpty()
        self._link: Path | None = None
        try:
            tty.setraw(self._device)
            os.set_blocking(self._end, False)
            self.device = os.ttyname(self._device)
            """Name of the device; programs open it as they would /dev/serial0."""
            if link is not None:
                self._make_link(link)
        except BaseException:
            self.close()
            raise

    @property
    def name(self) -> str:
        """What to open: the link, or else the device."""
        return self.device if self._link is None else str(self._link)

    def fileno(self) -> int:
        """For ``select``.

        Raises:
            TerminalError: it is closed.
        """
        if self._end is None:
            raise TerminalError("the serial port is closed")
        return self._end

    def read(self) -> bytes:
        """What a program wrote since; empty when nothing."""
        with suppress(BlockingIOError):
            return os.read(self.fileno(), CHUNK)
        return b""

    def write(self, data: bytes) -> int:
        """Hand bytes to whoever reads; returns how many there was room for."""
        if not data:
            return 0
        with suppress(BlockingIOError):
            return os.write(self.fileno(), data)
        return 0

    def close(self) -> None:
        """Take the port and its link away; may be called twice."""
        if self._end is None:
            return
        self._drop_link()
        os.close(self._end)
        os.close(self._device)
        self._end = None

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink():
                link.unlink()
            link.symlink_to(self.device)
        except FileExistsError as error:
            raise TerminalError(f"{link} is there and no link: it stays as it is") from error
        except OSError as error:
            raise TerminalError(f"no link {link} can be made: {error.strerror}") from error
        self._link = link

    def _drop_link(self) -> None:
        """Only our own: another program may have put its own there since."""
        link = self._link
        if link is not None and link.is_symlink() and str(link.readlink()) == self.device:
            link.unlink()
        self._link = None
