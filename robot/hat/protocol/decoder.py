"""Decodes bytes of a Build HAT to events, even if bytes are lost or garbled on the way.

A garbled byte spoils only its own line: a line ends at CR LF, or at one of them if the other was
lost.
"""

from __future__ import annotations

import re

from robot.hat.protocol.bootloader_events import BootloaderPrompt
from robot.hat.protocol.events import BusFault, Echo, Event, Unknown
from robot.hat.protocol.grammar import read_line

LONGEST = 512
"""Limit of a line [bytes]. No line of the board is longer: the longest, the signature, has 211."""

CR, LF, NUL = b"\r", b"\n", b"\0"
LINE_END = re.compile(rb"[\r\n]")
PROMPT = b"BHBL> "
FIRMWARE_PROMPTS = re.compile(rb"(?:P[0-3]>)+")
GLUED_ERROR = re.compile(rb"<[^<>]*bus (?:timeout|error)>|<P[0-3]: [^<>]*>")


class Decoder:
    """Decodes bytes; keeps the incomplete line between two calls."""

    def __init__(self) -> None:
        self._begun = b""
        self._echoes = False
        self._skipping = False
        self._after_cr = False

    def feed(self, data: bytes) -> list[Event]:
        """Return the events that these bytes complete; accept any bytes, in pieces of any size."""
        events: list[Event] = []
        position = 0
        for end in LINE_END.finditer(data):
            self._take(data[position : end.start()], events)
            position = end.end()
            self._end_line(end.group(), events)
        self._take(data[position:], events)
        return events

    def _take(self, piece: bytes, events: list[Event]) -> None:
        """Extend the incomplete line; detect the bootloader's prompt, which has no line end."""
        if not piece:
            return
        self._after_cr = False
        if self._skipping:
            return
        *before, rest = (self._begun + piece).split(PROMPT)
        for item in before:
            self._tell(item, events, even_empty=False)
            events.append(BootloaderPrompt())
            self._echoes = True
        self._begun = rest
        if len(rest) > LONGEST:
            events.append(Unknown(rest[:LONGEST]))
            self._begun = b""
            self._skipping = True

    def _end_line(self, end: bytes, events: list[Event]) -> None:
        ended = end == LF and self._after_cr
        self._after_cr = end == CR
        if ended:
            return
        if not self._skipping:
            self._tell(self._begun, events, even_empty=True)
        self._begun = b""
        self._echoes = self._skipping = False

    def _tell(self, line: bytes, events: list[Event], even_empty: bool) -> None:
        """Append the event of a line, and the events of messages that are glued to it."""
        # A break on the wire is read as NUL before the next message.
        line = line.lstrip(NUL)
        if b">" in line:
            line = self._unglued(line, events)
        if line or even_empty:
            events.append(self._meaning(line))

    def _unglued(self, line: bytes, events: list[Event]) -> bytes:
        """Return a line without bus errors and prompts, which have no line end of their own."""
        for error in GLUED_ERROR.findall(line):
            events.append(BusFault(error.decode("utf-8", "replace")))
        line = GLUED_ERROR.sub(b"", line)
        prompts = FIRMWARE_PROMPTS.match(line)
        if prompts is None:
            return line
        self._echoes = True
        return line[prompts.end() :]

    def _meaning(self, line: bytes) -> Event:
        """Return the event of a line: after a prompt an echo, unless only the board says it."""
        if self._echoes and not line:
            return Echo("")
        event = read_line(line) if len(line) <= LONGEST else Unknown(line[:LONGEST])
        if self._echoes and isinstance(event, Unknown):
            return Echo(line.decode("utf-8", "replace"))
        return event
