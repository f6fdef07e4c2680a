"""Collects the bytes of command lines, with the little editing that the firmware knows."""

from __future__ import annotations

from sim.hat.language.commands import execute
from sim.hat.language.session import Session
from sim.hat.language.words import Words

LONGEST = 256
"""What comes beyond is dropped, until the CR [bytes]."""

CR, BACKSPACE, DELETE = 0x0D, 0x08, 0x7F
COMMENT = b"#"


def raw_text(byte: int) -> str:
    """A byte as text that becomes the same byte again, whether or not it is a character."""
    return bytes([byte]).decode("utf-8", "surrogateescape")


class Terminal:
    """Only a CR ends a line; a LF is a character like any other."""

    __slots__ = ("_line", "_session")

    def __init__(self, session: Session) -> None:
        self._session = session
        self._line = bytearray()

    def hear(self, data: bytes) -> None:
        """Bytes from the host; lines that they end are executed at once."""
        for byte in data:
            if byte == CR:
                self._execute()
            elif byte in (BACKSPACE, DELETE):
                self._delete()
            elif len(self._line) < LONGEST:
                self._line.append(byte)
                if self._session.echo:
                    self._session.write(raw_text(byte))

    def prompt(self) -> None:
        """The current port, without an end of line; only where characters are echoed."""
        self._echo(f"P{self._session.current}>")

    def _delete(self) -> None:
        if self._line:
            self._line.pop()
            self._echo("\b \b")

    def _execute(self) -> None:
        """Every CR is answered by a line end first; a comment by nothing else."""
        self._session.write("\r\n")
        line = bytes(self._line)
        self._line.clear()
        if not line.startswith(COMMENT):
            execute(self._session, Words(line))
            self.prompt()

    def _echo(self, text: str) -> None:
        if self._session.echo:
            self._session.write(text)
