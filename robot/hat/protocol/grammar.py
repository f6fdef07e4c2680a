"""Grammar of the lines that a Build HAT sends.

The patterns are as strict as the board is regular: an integer has a sign unless it is zero, and
zero has a blank in place of the sign. So most lost, doubled or changed bytes are detected.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from robot.hat.protocol.bootloader_events import (
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
