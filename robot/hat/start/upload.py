"""The firmware's way into a Build HAT whose bootloader waits."""

from __future__ import annotations

from robot.hat.protocol import commands
from robot.hat.protocol.bootloader_events import (
    BootloaderPrompt,
    ChecksumFailure,
    ChecksumOk,
    SignatureReceived,
    UploadRefused,
    UploadTimeout,
    VerificationFailed,
)
from robot.hat.protocol.events import CommandError, Event, FirmwareVersion, InitDone
from robot.hat.start.firmware_image import FirmwareImage
from robot.hat.start.stage import Stage

TRIES = 3
SETTLE_S = 0.3
"""Until the answers to what was sent before have come; more than 3 kB fit in."""
PAYLOAD_AFTER_S = 0.1
"""From an announcement to what it announces, as all drivers of the board do."""
QUIET_S = 1.5
"""After a failure: the bootloader waits 1 s for a byte that was lost before it listens again."""

LIMITS_S = {
    Stage.CLEARING: 2.0,
    # The bytes alone take 4.5 s.
    Stage.LOADING: 7.0,
    Stage.SIGNING: 3.0,
    Stage.REBOOTING: 5.0,
    # A board that never falls silent runs its firmware after all.
    Stage.PAUSING: 15.0,
}

FAILURES: dict[type[Event], str] = {
    CommandError: "it did not understand a command",
    ChecksumFailure: "bytes were garbled on the way",
    UploadTimeout: "bytes were lost on the way",
    UploadRefused: "it refused what was announced",
    VerificationFailed: "the signature is not the firmware's",
}


class Upload:
    """Sends an image and starts it; again from the beginning after a failure, three times."""

    def __init__(self, image: FirmwareImage, now: float) -> None:
        self.stage = Stage.PAUSING
        self.done = False
        """Whether the firmware has started."""
        self.failed: str | None = None
        """Why the last try failed, when there is no further one."""
        self._image = image
        self._tries = 0
        self._since = self._heard = now
        self._prompted = False
        self._payload: bytes | None = None

    def begin(self, now: float) -> bytes:
        """A new try."""
        self._tries += 1
        self._prompted = False
        self._enter(Stage.CLEARING, now)
        # A firmware that has started unheard tells its version; to it, clear is clear_faults.
        return commands.clear() + commands.version()

    def receive(self, event: Event, now: float) -> bytes:
        """What the board said; returns what to send."""
        self._heard = now
        if self.stage in (Stage.LOADING, Stage.SIGNING, Stage.REBOOTING):
            failure = FAILURES.get(type(event))
            if failure is not None:
                return self._fail(failure, now)
        match self.stage, event:
            case Stage.CLEARING, BootloaderPrompt():
                self._prompted = True
            case Stage.LOADING, BootloaderPrompt() if now - self._since > SETTLE_S:
                # It listens to commands again: its complaint was lost on the way.
                return self._fail(FAILURES[UploadTimeout], now)
            case Stage.LOADING, ChecksumOk():
                signature = self._image.signature
                self._announce(Stage.SIGNING, signature, now)
                return commands.signature(len(signature))
            case Stage.SIGNING, SignatureReceived():
                self._enter(Stage.REBOOTING, now)
                return commands.reboot()
            case _, InitDone() | FirmwareVersion():
                self.done = True
        return b""

    def tick(self, now: float) -> bytes:
        """Time goes on; returns what to send."""
        passed = now - self._since
        if self._payload is not None and passed >= PAYLOAD_AFTER_S:
            payload, self._payload = self._payload, None
            return commands.payload(payload)
        if self.stage is Stage.PAUSING and now - self._heard >= QUIET_S:
            return self.begin(now)
        if self.stage is Stage.CLEARING and self._prompted and passed >= SETTLE_S:
            data = self._image.data
            self._announce(Stage.LOADING, data, now)
            return commands.load(len(data), self._image.checksum)
        if passed >= LIMITS_S[self.stage]:
            return self._fail(f"no answer while {self.stage.value}", now)
        return b""

    def _enter(self, stage: Stage, now: float) -> None:
        self.stage = stage
        self._since = now
        self._payload = None

    def _announce(self, stage: Stage, payload: bytes, now: float) -> None:
        self._enter(stage, now)
        self._payload = payload

    def _fail(self, reason: str, now: float) -> bytes:
        if self._tries >= TRIES:
            self.failed = reason
        self._enter(Stage.PAUSING, now)
        return b""
