"""Decodes bytes of a Build HAT to events, even if bytes are lost or garbled on the way.

A garbled byte spoils only its own line: a line ends at CR LF, or at one of them if the other was
lost. The patterns of lines are as strict as the board is regular: an integer has a sign unless it
is zero, and zero has a blank in place of the sign. So most lost, doubled or changed bytes are
detected.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from robot.hat.protocol.bootloader_events import (
    BootloaderPrompt,
    BootloaderVersion,
    ChecksumFailure,
    ChecksumOk,
    ImageReceived,
    Rebooting,
    SignatureReceived,
    UploadRefused,
    UploadTimeout,
    VerificationFailed,
    Verified,
)
from robot.hat.protocol.events import (
    Answered,
    Banner,
    BusFault,
    Button,
    CombiData,
    CommandRefused,
    Connected,
    Connecting,
    ConnectionFailed,
    DescriptionLine,
    Disconnected,
    Echo,
    Established,
    Event,
    FaultDump,
    FirmwareVersion,
    InitDone,
    Late,
    ModeData,
    MotorPowerFault,
    NoDevice,
    PortPowerFault,
    PulseDone,
    QueueOverrun,
    RampDone,
    Signature,
    Supply,
    Unknown,
    Value,
)

INTEGER = rb"(?:[+-][1-9][0-9]{0,9}| 0)"
REAL = rb"(?: ?[+-]?(?:[0-9]+\.[0-9]*(?:E[+-]?[0-9]+)?|Inf|NaN))"
HEX_LINE = rb" ?[0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2}){31,63} ?"
VALUES = rb"((?: (?:" + INTEGER + rb"|" + REAL + rb"))+)"

Fields = tuple[bytes, ...]


def _values(text: bytes) -> tuple[float, ...]:
    return tuple(float(number) for number in text.split())


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace")


MEANINGS: tuple[tuple[bytes, Callable[[Fields], Event]], ...] = (
    (rb"P([0-3])C([0-7]):" + VALUES, lambda f: CombiData(int(f[0]), int(f[1]), _values(f[2]))),
    (rb"P([0-3])M([0-9]{1,2}):" + VALUES, lambda f: ModeData(int(f[0]), int(f[1]), _values(f[2]))),
    (
        rb"P([0-3])V: ( ?[+-]?[0-9]{6}|" + REAL + rb")",
        lambda f: Value(int(f[0]), float(f[1])),
    ),
    (rb"", lambda f: Answered()),
    (rb"Error", lambda f: CommandRefused()),
    (rb"([0-9]{1,2}\.[0-9]{2}) V", lambda f: Supply(float(f[0]))),
    (rb"P([0-3]): pulse done", lambda f: PulseDone(int(f[0]))),
    (rb"P([0-3]): ramp done", lambda f: RampDone(int(f[0]))),
    (rb"P([0-3]): connecting to active device", lambda f: Connecting(int(f[0]))),
    (
        rb"P([0-3]): connected to active ID ([0-9A-F]{2})",
        lambda f: Connected(int(f[0]), int(f[1], 16), False),
    ),
    (
        rb"P([0-3]): connected to passive ID ([0-9]{1,3})",
        lambda f: Connected(int(f[0]), int(f[1]), True),
    ),
    (
        rb"P([0-3]): established serial communication with active ID ([0-9A-F]{2})",
        lambda f: Established(int(f[0]), int(f[1], 16)),
    ),
    (rb"P([0-3]): no device detected", lambda f: NoDevice(int(f[0]))),
    (rb"P([0-3]): disconnected", lambda f: Disconnected(int(f[0]))),
    (
        rb"P([0-3]): (timeout during (?:data|setup) phase|framing error|checksum error"
        rb"|too many errors \([^()]*\)): disconnecting",
        lambda f: ConnectionFailed(int(f[0]), _text(f[1])),
    ),
    (
        rb"P([0-3]): button (pressed|released)",
        lambda f: Button(int(f[0]), f[1] == b"pressed"),
    ),
    (rb"Motor power fault", lambda f: MotorPowerFault()),
    (rb"Port power fault", lambda f: PortPowerFault()),
    (
        rb"( Port(?: [0-9A-F]{2}){3}| {1,3}[0-9](?: {1,2}[0-9A-F]{2}){3})",
        lambda f: FaultDump(_text(f[0])),
    ),
    (rb"deltat=([0-9A-Fa-f]{8})", lambda f: Late(int(f[0], 16))),
    (rb"MQ overrun!", lambda f: QueueOverrun()),
    (rb"(Attempting reset of I.{1,4}C bus)", lambda f: BusFault(_text(f[0]))),
    (
        rb"Firmware version: ([0-9]{1,12}) (\S+)",
        lambda f: FirmwareVersion(int(f[0]), _text(f[1])),
    ),
    (rb"Firmware signature:((?: [0-9A-F]{2}){64})", lambda f: Signature(_text(f[0]).strip())),
    (
        rb"BuildHAT bootloader version ([0-9]{1,12}) (\S+)",
        lambda f: BootloaderVersion(int(f[0]), _text(f[1])),
    ),
    (rb"Done initialising ports", lambda f: InitDone()),
    (rb"Image received", lambda f: ImageReceived()),
    (rb"Checksum OK", lambda f: ChecksumOk()),
    (rb"Checksum failure", lambda f: ChecksumFailure()),
    (rb"Signature received", lambda f: SignatureReceived()),
    (rb"Timed out waiting for data", lambda f: UploadTimeout()),
    (
        rb"(Image too large .*|Incorrect signature length .*|No image loaded)",
        lambda f: UploadRefused(_text(f[0])),
    ),
    # The bootloader says "verifed"; a later version may spell it correctly.
    (rb"Image verifi?ed OK", lambda f: Verified()),
    (rb"Image verification failed", lambda f: VerificationFailed()),
    (rb"Rebooting\.\.\.", lambda f: Rebooting()),
    (
        rb"(type [0-9A-F]{1,2}|  (?:nmodes|nview|baud|hwver|swver) *=.*|  M[0-9]{1,2} .* SI = ?.*"
        rb"|    (?:format|RAW:) ?.*|  C[0-7]: ?.*| +(?:speed|position) PID: .*)",
        lambda f: DescriptionLine(_text(f[0])),
    ),
    (
        rb"(Type help <RETURN> for help|Initialising ports|Resetting drivers: .*"
        rb"|Reading driver dumps: .*|set baud rate to [0-9]+|Verifying image.*|SHA256:.*"
        rb"|Public key:.*|" + HEX_LINE + rb")",
        lambda f: Banner(_text(f[0])),
    ),
)
PATTERNS = tuple((re.compile(pattern), meaning) for pattern, meaning in MEANINGS)


def read_line(line: bytes) -> Event:
    """Return the event of a line without its end; ``Unknown`` if no pattern matches."""
    for pattern, meaning in PATTERNS:
        result = pattern.fullmatch(line)
        if result is not None:
            return meaning(result.groups())
    return Unknown(line)


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
