"""Decodes bytes of a Build HAT to events, even if bytes are lost or garbled on the way.

A garbled byte spoils only its own line: a line ends at CR LF, or at one of them if the other was
lost. The patterns of lines are as strict as the board is regular: an integer has a sign unless it
is zero, and zero has a blank in place of the sign. So most lost, doubled or changed bytes are
detected.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from robot.hat.protocol.events import (
    Answered,
    BootloaderPrompt,
    BootloaderVersion,
    ChecksumFailure,
    ChecksumOk,
    CombiData,
    CommandRefused,
    Connected,
    ConnectionFailed,
    Disconnected,
    Echo,
    Established,
    Event,
    FirmwareVersion,
    InitDone,
    MotorPowerFault,
    NoDevice,
    Notice,
    PortPowerFault,
    SignatureReceived,
    SupplyVoltage,
    UnknownLine,
    UploadRefused,
    UploadTimeout,
    VerificationFailed,
)

INTEGER = rb"(?:[+-][1-9][0-9]{0,9}| 0)"
REAL = rb"(?: ?[+-]?(?:[0-9]+\.[0-9]*(?:E[+-]?[0-9]+)?|Inf|NaN))"
HEX_LINE = rb" ?[0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2}){31,63} ?"
VALUES = rb"((?: (?:" + INTEGER + rb"|" + REAL + rb"))+)"

Fields = tuple[bytes, ...]
PORT = rb"P([0-3])"
NOTICES = re.compile(
    rb"|".join(
        [
            # Of a port: values that were not asked for, and what it is doing.
            PORT + rb"M[0-9]{1,2}:" + VALUES,
            PORT + rb"V: (?: ?[+-]?[0-9]{6}|" + REAL + rb")",
            PORT + rb": (?:pulse done|ramp done|connecting to active device|button pressed)",
            PORT + rb": button released",
            # Of a device: its description.
            rb"type [0-9A-F]{1,2}",
            rb"  (?:nmodes|nview|baud|hwver|swver) *=.*",
            rb"  M[0-9]{1,2} .* SI = ?.*",
            rb"    (?:format|RAW:) ?.*",
            rb"  C[0-7]: ?.*",
            rb" +(?:speed|position) PID: .*",
            # Of the firmware: its registers after a fault, its trouble, its start.
            rb" Port(?: [0-9A-F]{2}){3}",
            rb" {1,3}[0-9](?: {1,2}[0-9A-F]{2}){3}",
            rb"deltat=[0-9A-Fa-f]{8}",
            rb"MQ overrun!",
            rb"Attempting reset of I.{1,4}C bus",
            rb"Firmware signature:(?: [0-9A-F]{2}){64}",
            rb"Type help <RETURN> for help",
            rb"Initialising ports",
            rb"Resetting drivers: .*",
            rb"Reading driver dumps: .*",
            rb"set baud rate to [0-9]+",
            # Of the bootloader; it says "verifed", a later version may spell it correctly.
            rb"Image received",
            rb"Image verifi?ed OK",
            rb"Rebooting\.\.\.",
            rb"Verifying image.*",
            rb"SHA256:.*",
            rb"Public key:.*",
            HEX_LINE,
        ]
    )
)
"""Lines that change nothing here, but are no ``UnknownLine``: a stranger at the port says those."""
LONGEST = 512
"""Limit of a line [bytes]. No line of the board is longer: the longest, the signature, has 211."""
CR, LF, NUL = b"\r", b"\n", b"\0"
LINE_END = re.compile(rb"[\r\n]")
PROMPT = b"BHBL> "
FIRMWARE_PROMPTS = re.compile(rb"(?:P[0-3]>)+")
GLUED_ERROR = re.compile(rb"<[^<>]*bus (?:timeout|error)>|<P[0-3]: [^<>]*>")


def _values(text: bytes) -> tuple[float, ...]:
    return tuple(float(number) for number in text.split())


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace")


MEANINGS: tuple[tuple[bytes, Callable[[Fields], Event]], ...] = (
    (PORT + rb"C([0-7]):" + VALUES, lambda f: CombiData(int(f[0]), int(f[1]), _values(f[2]))),
    (rb"", lambda f: Answered()),
    (rb"Error", lambda f: CommandRefused()),
    (rb"([0-9]{1,2}\.[0-9]{2}) V", lambda f: SupplyVoltage(float(f[0]))),
    (
        PORT + rb": connected to active ID ([0-9A-F]{2})",
        lambda f: Connected(int(f[0]), int(f[1], 16), False),
    ),
    (
        PORT + rb": connected to passive ID ([0-9]{1,3})",
        lambda f: Connected(int(f[0]), int(f[1]), True),
    ),
    (
        PORT + rb": established serial communication with active ID ([0-9A-F]{2})",
        lambda f: Established(int(f[0]), int(f[1], 16)),
    ),
    (PORT + rb": no device detected", lambda f: NoDevice(int(f[0]))),
    (PORT + rb": disconnected", lambda f: Disconnected(int(f[0]))),
    (
        PORT + rb": (timeout during (?:data|setup) phase|framing error|checksum error"
        rb"|too many errors \([^()]*\)): disconnecting",
        lambda f: ConnectionFailed(int(f[0]), _text(f[1])),
    ),
    (rb"Motor power fault", lambda f: MotorPowerFault()),
    (rb"Port power fault", lambda f: PortPowerFault()),
    (
        rb"Firmware version: ([0-9]{1,12}) (\S+)",
        lambda f: FirmwareVersion(int(f[0]), _text(f[1])),
    ),
    (
        rb"BuildHAT bootloader version ([0-9]{1,12}) (\S+)",
        lambda f: BootloaderVersion(int(f[0]), _text(f[1])),
    ),
    (rb"Done initialising ports", lambda f: InitDone()),
    (rb"Checksum OK", lambda f: ChecksumOk()),
    (rb"Checksum failure", lambda f: ChecksumFailure()),
    (rb"Signature received", lambda f: SignatureReceived()),
    (rb"Timed out waiting for data", lambda f: UploadTimeout()),
    (
        rb"(Image too large .*|Incorrect signature length .*|No image loaded)",
        lambda f: UploadRefused(_text(f[0])),
    ),
    (rb"Image verification failed", lambda f: VerificationFailed()),
)
PATTERNS = tuple((re.compile(pattern), meaning) for pattern, meaning in MEANINGS)


def read_line(line: bytes) -> Event:
    """Return the event of a line without its end; ``UnknownLine`` if no pattern matches."""
    for pattern, meaning in PATTERNS:
        result = pattern.fullmatch(line)
        if result is not None:
            return meaning(result.groups())
    return Notice(_text(line)) if NOTICES.fullmatch(line) else UnknownLine(line)


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
            events.append(UnknownLine(rest[:LONGEST]))
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
            events.append(Notice(_text(error)))
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
        event = read_line(line) if len(line) <= LONGEST else UnknownLine(line[:LONGEST])
        if self._echoes and isinstance(event, UnknownLine):
            return Echo(_text(line))
        return event
