"""Upload of the firmware to a Build HAT whose bootloader is waiting."""

from __future__ import annotations

from enum import Enum

from robot.hat.protocol import commands
from robot.hat.protocol.events import (
    BootloaderPrompt,
    ChecksumFailure,
    ChecksumOk,
    CommandRefused,
    Event,
    FirmwareVersion,
    InitDone,
    SignatureReceived,
    UploadRefused,
    UploadTimeout,
    VerificationFailed,
)
from robot.hat.start.firmware_image import FirmwareImage


class Stage(Enum):
    """A stage of the start; its value is the text that users see."""

    ASKING = "asking which firmware runs"
    CLEARING = "preparing the upload of the firmware"
    LOADING = "sending the firmware, which takes five seconds"
    SIGNING = "sending the firmware's signature"
    REBOOTING = "starting the firmware"
    PAUSING = "waiting for quiet before the firmware is sent again"
    RESETTING = "resetting the board"
    LISTING = "asking what is at the ports"
    RUNNING = "running"
    FAILED = "waiting before the next try"


TRIES = 3
SETTLE_S = 0.3
"""Time until the answers to earlier commands have come [s]; more than 3 kB arrive in it."""
PAYLOAD_AFTER_S = 0.1
"""Time from an announcement to the announced data [s], as in all drivers of the board."""
QUIET_S = 1.5
"""Silence after a failure [s]: the bootloader waits 1 s for a lost byte before it listens again."""

LIMITS_S = {
    Stage.CLEARING: 2.0,
    # The bytes alone take 4.5 s.
    Stage.LOADING: 7.0,
    Stage.SIGNING: 3.0,
    Stage.REBOOTING: 5.0,
    # A board that never falls silent is running its firmware after all.
    Stage.PAUSING: 15.0,
}

FAILURES: dict[type[Event], str] = {
    CommandRefused: "it did not understand a command",
    ChecksumFailure: "bytes were garbled on the way",
    UploadTimeout: "bytes were lost on the way",
    UploadRefused: "it refused what was announced",
    VerificationFailed: "the signature is not the firmware's",
}


class Upload:
    """Sends an image and starts it; after a failure it begins again, up to three tries."""

    def __init__(self, image: FirmwareImage, current: float) -> None:
        self.stage = Stage.PAUSING
        self.done = False
        """Whether the firmware has started."""
        self.failed: str | None = None
        """Why the last of all tries failed; None while more tries are left."""
        self._image = image
        self._tries = 0
        self._since = self._heard = current
        self._prompted = False
        self._payload: bytes | None = None

    def begin(self, current: float) -> bytes:
        """Begin a new try; return what to send."""
        self._tries += 1
        self._prompted = False
        self._enter(Stage.CLEARING, current)
        # A firmware that started unnoticed answers with its version; to it, clear is clear_faults.
        return commands.clear() + commands.version()

    def receive(self, event: Event, current: float) -> bytes:
        """Take a message of the board; return what to send."""
        self._heard = current
        if self.stage in (Stage.LOADING, Stage.SIGNING, Stage.REBOOTING):
            failure = FAILURES.get(type(event))
            if failure is not None:
                return self._fail(failure, current)
        match self.stage, event:
            case Stage.CLEARING, BootloaderPrompt():
                self._prompted = True
            case Stage.LOADING, BootloaderPrompt() if current - self._since > SETTLE_S:
                # The bootloader accepts commands again: its error message was lost on the way.
                return self._fail(FAILURES[UploadTimeout], current)
            case Stage.LOADING, ChecksumOk():
                signature = self._image.signature
                self._announce(Stage.SIGNING, signature, current)
                return commands.signature(len(signature))
            case Stage.SIGNING, SignatureReceived():
                self._enter(Stage.REBOOTING, current)
                return commands.reboot()
            case _, InitDone() | FirmwareVersion():
                self.done = True
        return b""

    def tick(self, current: float) -> bytes:
        """Act on the time that has passed; return what to send."""
        passed = current - self._since
        if self._payload is not None and passed >= PAYLOAD_AFTER_S:
            payload, self._payload = self._payload, None
            return commands.payload(payload)
        if self.stage is Stage.PAUSING and current - self._heard >= QUIET_S:
            return self.begin(current)
        if self.stage is Stage.CLEARING and self._prompted and passed >= SETTLE_S:
            data = self._image.data
            self._announce(Stage.LOADING, data, current)
            return commands.load(len(data), self._image.checksum)
        if passed >= LIMITS_S[self.stage]:
            return self._fail(f"no answer while {self.stage.value}", current)
        return b""

    def _enter(self, stage: Stage, current: float) -> None:
        self.stage = stage
        self._since = current
        self._payload = None

    def _announce(self, stage: Stage, payload: bytes, current: float) -> None:
        self._enter(stage, current)
        self._payload = payload

    def _fail(self, reason: str, current: float) -> bytes:
        if self._tries >= TRIES:
            self.failed = reason
        self._enter(Stage.PAUSING, current)
        return b""
