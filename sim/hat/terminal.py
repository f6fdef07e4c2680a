"""Collects the bytes of command lines, with the simple editing of the firmware."""

from __future__ import annotations

from sim.hat.commands import Session, execute
from sim.hat.words import Words

LONGEST = 256
"""Longest line [bytes]; further bytes are dropped until the CR."""

CR, BACKSPACE, DELETE = 0x0D, 0x08, 0x7F
COMMENT = b"#"


def raw_text(byte: int) -> str:
    """Return a byte as text that encodes to the same byte again, even if it is not valid UTF-8."""
    return bytes([byte]).decode("utf-8", "surrogateescape")


class Terminal:
    """Collects lines and executes them. Only a CR ends a line; a LF is an ordinary character."""

    __slots__ = ("_line", "_session")

    def __init__(self, session: Session) -> None:
        self._session = session
        self._line = bytearray()

    def hear(self, data: bytes) -> None:
        """Take bytes from the host; execute each completed line at once."""
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
        """Print the current port, without a line end, if characters are echoed."""
        self._echo(f"P{self._session.current}>")

    def _delete(self) -> None:
        if self._line:
            self._line.pop()
            self._echo("\b \b")

    def _execute(self) -> None:
        """Print a line end; then execute the line and print the prompt, unless it is a comment."""
        self._session.write("\r\n")
        line = bytes(self._line)
        self._line.clear()
        if not line.startswith(COMMENT):
            execute(self._session, Words(line))
            self.prompt()

    def _echo(self, text: str) -> None:
        if self._session.echo:
            self._session.write(text)
