"""The Build HAT's bootloader: it receives a firmware over the serial line and starts it.

It always echoes. No line end follows its prompt, so a client that reads lines finds the prompt
directly before the echo of the next command. The real bootloader's spelling mistakes are kept.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Generator
from enum import Enum, auto

from robot.errors import CommandError
from sim.hat.words import CommandWords

STX, ETX = 0x02, 0x03

TIME_OUT = 1.0
"""The upload fails after waiting longer than this for the next byte [s]."""
VERSION = "1631704133 2021-09-15T12:08:53+01:00"
"""The version that real boards report."""
PROMPT = "BHBL> "
MAX_IMAGE = 245_760
SIGNATURE_LENGTH = 64
MAX_LINE = 256
START_UP = 0.01
"""Period of the start-up [s]. At the end of each period, one byte received meanwhile is dropped;
the start-up ends when there is none left."""
RING = 4096
"""Size of its input ring buffer; one byte of it always stays empty."""
BEFORE_JUMP = 0.1
"""Time between ``Rebooting...`` and the first instruction of the firmware [s]."""
CR, BACKSPACE, DELETE = 0x0D, 0x08, 0x7F
COMMANDS = ("help", "?", "load", "signature", "clear", "verify", "reboot", "version")
"""A shortened word means the first command that begins with it: ``v`` is verify."""
HELP = (
    "help, ?                   this list",
    "version                   the bootloader's version",
    "load <length> <checksum>  take an image: STX, the bytes, ETX",
    "signature <length>        take its signature: STX, 64 bytes, ETX",
    "clear                     forget the image",
    "verify                    check the image against its signature",
    "reboot                    verify, then start the image",
)
PUBLIC_KEY = hashlib.sha512(b"no key: the emulated board accepts any signature").digest()
"""Arbitrary bytes instead of the board's key."""
Work = Generator[None, None, None]
"""Execution of a line; it pauses during an upload or a reboot."""


class UploadStage(Enum):
    """State of an upload: what it waits for, or how it ended."""

    START = auto()
    DATA = auto()
    END = auto()
    COMPLETE = auto()
    TIMED_OUT = auto()


class IncomingUpload:
    """One upload; ``data`` is complete when ``stage`` is COMPLETE.

    Bytes before STX, and between the last byte of data and ETX, are skipped; they do not extend
    the time-out.
    """

    def __init__(self, length: int) -> None:
        self.stage = UploadStage.START
        self.data = bytearray()
        self._length = length
        self._waited = 0.0

    def receive(self, byte: int) -> None:
        """Take the next byte from the line."""
        if self.stage is UploadStage.START and byte == STX:
            self._go_on(UploadStage.DATA if self._length else UploadStage.END)
        elif self.stage is UploadStage.DATA:
            self.data.append(byte)
            self._go_on(UploadStage.DATA if len(self.data) < self._length else UploadStage.END)
        elif self.stage is UploadStage.END and byte == ETX:
            self._go_on(UploadStage.COMPLETE)

    def tick(self, seconds: float) -> None:
        """Let time pass [s]."""
        self._waited += seconds
        # The small term allows for the rounding of added milliseconds.
        if self._waited > TIME_OUT + 1e-6:
            self.stage = UploadStage.TIMED_OUT

    def _go_on(self, stage: UploadStage) -> None:
        self.stage = stage
        self._waited = 0.0


def checksum(data: bytes) -> int:
    """Return the 32-bit checksum that ``load`` compares; for no bytes it is 1."""
    register = 1
    for byte in data:
        register <<= 1
        if register >> 32:
            register ^= 0x1_1D87_2B41
        register ^= byte
    return register


class Bootloader:
    """Takes bytes one by one, and writes text through ``put``; ``tick`` makes time pass.

    A signature is not verified, because that needs the owner's key: any signature is accepted.
    """

    def __init__(self, put: Callable[[bytes], None]) -> None:
        """Start it: it writes its greeting at once."""
        self.rebooted = False
        """Whether the firmware has been started, so the bootloader has ended."""
        self.image = b""
        self.signature = b""
        self._put = put
        self._line = bytearray()
        self._work: Work | None = None
        self._upload: IncomingUpload | None = None
        self._pause = START_UP
        self._spurious = 0
        self._starting = True
        self._print("")
        self._print("Type help <RETURN> for help")
        self._put(PROMPT.encode())

    def receive(self, byte: int) -> None:
        """Take one byte from the line."""
        if self._starting:
            self._spurious = min(self._spurious + 1, RING - 1)
        elif self._upload is not None:
            self._upload.receive(byte)
            self._look_at_upload(self._upload)
        elif self._work is None:
            self._edit(byte)

    def tick(self, seconds: float) -> None:
        """Let time pass [s]: an upload may time out, and a reboot may finish."""
        if self._upload is not None:
            self._upload.tick(seconds)
            self._look_at_upload(self._upload)
            return
        if self._starting or self._work is not None:
            self._pause -= seconds
            if self._pause < 1e-9:
                self._end_pause()

    def _end_pause(self) -> None:
        if self._starting:
            self._starting = self._spurious > 0
            self._spurious = max(self._spurious - 1, 0)
            self._pause = START_UP
        else:
            self._go_on()

    def _look_at_upload(self, upload: IncomingUpload) -> None:
        if upload.stage in (UploadStage.COMPLETE, UploadStage.TIMED_OUT):
            self._go_on()

    def _edit(self, byte: int) -> None:
        if byte == CR:
            self._print("")
            line, self._line = bytes(self._line), bytearray()
            self._work = self._execute(CommandWords(line))
            self._go_on()
        elif byte in (BACKSPACE, DELETE):
            if self._line:
                self._line.pop()
                self._put(b"\b \b")
        elif len(self._line) < MAX_LINE:
            self._line.append(byte)
            self._put(bytes([byte]))

    def _go_on(self) -> None:
        """Continue the work until it has to wait again or is done."""
        assert self._work is not None
        try:
            next(self._work)
        except StopIteration:
            self._work = None

    def _execute(self, words: CommandWords) -> Work:
        try:
            while words.next_command():
                yield from self._command(words)
                if self.rebooted:
                    return
        except CommandError:
            self._print("Error")
        self._put(PROMPT.encode())

    def _command(self, words: CommandWords) -> Work:
        name = words.choice(COMMANDS)
        if name == "load":
            yield from self._load(words)
        elif name == "signature":
            yield from self._sign(words)
        elif name == "reboot":
            yield from self._reboot()
        elif name is None:
            raise CommandError(f"valid are {', '.join(COMMANDS)}")
        else:
            self._answer(name)

    def _answer(self, name: str) -> None:
        """Execute a command that is done at once."""
        if name == "clear":
            self.image = b""
        elif name == "verify":
            self._verify()
        else:
            self._print(f"BuildHAT bootloader version {VERSION}")
            if name != "version":
                self._print("Commands available:", *(f"  {line}" for line in HELP))

    def _load(self, words: CommandWords) -> Work:
        self.image = b""
        length, expected = words.unsigned(), words.unsigned()
        if length > MAX_IMAGE:
            self._print("", f"Image too large (maximum {MAX_IMAGE} bytes)")
            raise CommandError("the image is too large")
        data = yield from self._take(length)
        self._print("", "Image received")
        if checksum(data) != expected:
            self._print("Checksum failure")
            raise CommandError("the checksum is wrong")
        self._print("Checksum OK")
        self.image = data

    def _sign(self, words: CommandWords) -> Work:
        if words.unsigned() != SIGNATURE_LENGTH:
            self._print("", f"Incorrect signature length (should be{SIGNATURE_LENGTH} bytes)")
            raise CommandError("a signature has another length")
        self.signature = yield from self._take(SIGNATURE_LENGTH)
        self._print("", "Signature received")

    def _take(self, length: int) -> Generator[None, None, bytes]:
        upload = self._upload = IncomingUpload(length)
        yield
        self._upload = None
        if upload.stage is UploadStage.TIMED_OUT:
            self._print("", "Timed out waiting for data")
            raise CommandError("the data did not come")
        return bytes(upload.data)

    def _verify(self) -> None:
        if not self.image:
            self._print("No image loaded")
            raise CommandError("there is no image")
        ends = bytes([self.image[0], self.image[0], *self.image[-2:]])
        self._print("Verifying image...")
        self._print(f"Verifying image length={len(self.image)} {_hex(ends)}")
        self._print("SHA256:", f" {_hex(hashlib.sha256(self.image).digest())}")
        self._print("Public key:", f" {_hex(PUBLIC_KEY)}")
        if not self.signature:
            self._print("Image verification failed")
            raise CommandError("there is no signature")
        self._print("Image verifed OK")

    def _reboot(self) -> Work:
        self._verify()
        self._print("Rebooting...")
        self._pause = BEFORE_JUMP
        yield
        self.rebooted = True

    def _print(self, *lines: str) -> None:
        for line in lines:
            self._put(f"{line}\r\n".encode())


def _hex(data: bytes) -> str:
    return data.hex(" ").upper()
