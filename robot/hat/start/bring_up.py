"""Brings up a Build HAT: from an open port to the right firmware with its motors stopped.

There is no I/O and no clock: the caller passes events and times [s], and sends the returned bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from robot.hat.protocol import commands
from robot.hat.protocol.events import (
    Answered,
    BootloaderPrompt,
    BootloaderVersion,
    Connected,
    Echo,
    Event,
    FirmwareVersion,
    InitDone,
    NoDevice,
    UnknownLine,
)
from robot.hat.start import troubles
from robot.hat.start.firmware_image import EXPECTED_VERSION, FirmwareImage, FirmwareImageError
from robot.hat.start.upload import TRIES, Stage, Upload

ASK_S = 1.2
"""Time between two questions to a board that does not answer [s]; there is no limit to their
number. It is more than a second: a bootloader waits that long for the next byte of an image that an
earlier program left unfinished, and would take a question for a part of the image."""
STOP_EVERY = 5
"""One in this many questions includes the motors' stop. The bootloader takes 10 ms for each byte
that waited while it started; if each question included the stop, it would stay deaf."""
SILENT_S = 3.0
"""A board that does not answer for this time is reported [s]."""
RESET_S = 8.0
"""A board that is silent for this time is reset by its pin, once [s]. A bootloader that was started
in the middle of an upload is deaf for up to 41 s, and a firmware may hang."""
LIST_S = 1.0
"""How long to wait for an answer to list [s]; it takes 0.1 s for each motor."""
LISTS = 3
BOOT_S = 0.5
"""Time from a reset to the bootloader's first message [s]."""
AGAIN_S = 10.0
"""Time from a failure to the next try [s]."""


class BringUp:
    """Asks, uploads, resets and lists until the board is ready; starts again if it restarts.

    The motors are told to stop with the first question and again after its answer. So the motors of
    a board that was left running stop as soon as it hears one of the two.
    """

    def __init__(self, image: Callable[[], FirmwareImage] = FirmwareImage.installed) -> None:
        """``image`` is called when a firmware must be sent; it raises if there is none."""
        self.stage = Stage.ASKING
        self.wants_reset = False
        """Whether the board must be reset by its pin; answer with was_reset or cannot_reset."""
        self.ready = False
        """Whether the right firmware runs, its reports are off and its ports are known."""
        self.trouble: str | None = None
        """Why the board is not ready, with the cure; None while nothing is wrong."""
        self.version: int | None = None
        """Version of the running firmware, if known."""
        self._image = image
        self._upload: Upload | None = None
        self._silent_since = self._since = 0.0
        self._strange: bytes | None = None
        self._heard = False
        self._listed: set[int] = set()
        self._lists = 0
        self._asked = 0
        self._reset_tried = False
        """Whether a silent board has been reset already."""
        self._wrong_version: int | None = None
        """The version in the board's last answer, if it was not the right one."""

    def begin(self, current: float) -> bytes:
        """Find out the board's state, after the port was opened or the board fell silent."""
        self.ready = False
        self.wants_reset = False
        self.trouble = None
        self.version = None
        self._reset_tried = False
        return self._restart_asking(current)

    def receive(self, events: Sequence[Event], current: float) -> bytes:
        """Take all messages of the board, at any stage; return what to send."""
        return b"".join(self._hear(event, current) for event in events)

    def tick(self, current: float) -> bytes:
        """Act on the time that has passed; return what to send."""
        if self._upload is not None:
            sent = self._upload.tick(current)
            return sent + self._follow_upload(current)
        passed = current - self._since
        match self.stage:
            case Stage.ASKING if passed >= ASK_S:
                return self._retry_version(current)
            case Stage.LISTING if passed >= LIST_S:
                return self._list_again(current)
            case Stage.RESETTING if not self.wants_reset and passed >= BOOT_S:
                return self._restart_asking(current)
            case Stage.FAILED if passed >= AGAIN_S:
                return self._restart_asking(current)
        return b""

    def was_reset(self, current: float) -> None:
        """Take note that the board was reset by its pin; it is asked again after its boot time."""
        self.wants_reset = False
        self._enter(Stage.RESETTING, current)

    def cannot_reset(self, reason: str, current: float) -> None:
        """Take note that the pin could not be used; the board is asked again later."""
        self.wants_reset = False
        if self.version is None:
            self._enter(Stage.ASKING, current)
            return
        self._fail(troubles.no_reset(self.version, reason), current)

    def _retry_version(self, current: float) -> bytes:
        """Ask again, as no answer came; in the end, request a reset of the board."""
        silent = current - self._silent_since
        if silent >= SILENT_S:
            self.trouble = self._diagnosis()
        if silent < RESET_S or self._reset_tried:
            return self._ask(current)
        self._reset_tried = self.wants_reset = True
        self._enter(Stage.RESETTING, current)
        return b""

    def _hear(self, event: Event, current: float) -> bytes:
        if self._upload is not None:
            sent = self._upload.receive(event, current)
            self.stage = self._upload.stage
            return sent + self._follow_upload(current)
        match self.stage:
            case Stage.ASKING:
                return self._hear_answer(event, current)
            case Stage.LISTING | Stage.RUNNING if _restarted(event):
                return self.begin(current)
            case Stage.LISTING:
                self._hear_port(event)
        return b""

    def _hear_answer(self, event: Event, current: float) -> bytes:
        match event:
            case FirmwareVersion(version):
                self.version = version
                return self._hear_version(version, current)
            case BootloaderVersion():
                return self._begin_upload(current)
            case UnknownLine(raw):
                self._strange = raw
            case Answered() | Echo():
                # Any device that echoes its input produces these too.
                pass
            case _:
                self._heard = True
        return b""

    def _hear_version(self, version: int, current: float) -> bytes:
        if version == EXPECTED_VERSION:
            self._lists = 0
            self._listed = set()
            return commands.stop() + commands.silence() + self._list(current)
        if version != self._wrong_version:
            # A digit may have been garbled, and a reset costs eight seconds: ask once more.
            self._wrong_version = version
            return self._ask(current)
        self._wrong_version = None
        self.trouble = troubles.wrong_version(version)
        self.wants_reset = True
        self._enter(Stage.RESETTING, current)
        return b""

    def _hear_port(self, event: Event) -> None:
        if isinstance(event, Connected | NoDevice):
            self._listed.add(event.port)
        if self._listed == set(commands.PORTS):
            self.stage = Stage.RUNNING
            self.ready = True
            self.trouble = None

    def _begin_upload(self, current: float) -> bytes:
        self.trouble = None
        self.version = None
        try:
            self._upload = Upload(self._image(), current)
        except FirmwareImageError as error:
            self._fail(str(error), current)
            return b""
        sent = self._upload.begin(current)
        self.stage = self._upload.stage
        return sent

    def _follow_upload(self, current: float) -> bytes:
        """Continue if the upload has ended, with success or failure."""
        upload = self._upload
        assert upload is not None
        self.stage = upload.stage
        if upload.failed is not None:
            self._upload = None
            self._fail(troubles.upload_failed(TRIES, upload.failed), current)
        elif upload.done:
            self._upload = None
            return self._restart_asking(current)
        return b""

    def _restart_asking(self, current: float) -> bytes:
        self._upload = None
        self._silent_since = current
        self._strange = None
        self._heard = False
        self._asked = 0
        return self._ask(current)

    def _ask(self, current: float) -> bytes:
        """Ask for the version, after the end of a line that a program may have left half sent."""
        self._enter(Stage.ASKING, current)
        stop = b"" if self._asked % STOP_EVERY else commands.stop()
        self._asked += 1
        return commands.line() + stop + commands.version()

    def _list(self, current: float) -> bytes:
        self._lists += 1
        self._enter(Stage.LISTING, current)
        return commands.devices()

    def _list_again(self, current: float) -> bytes:
        if self._lists < LISTS:
            return self._list(current)
        self.trouble = troubles.HALF_HEARD
        return self._restart_asking(current)

    def _enter(self, stage: Stage, current: float) -> None:
        self.stage = stage
        self._since = current

    def _fail(self, trouble: str, current: float) -> None:
        self.trouble = trouble
        self._enter(Stage.FAILED, current)

    def _diagnosis(self) -> str:
        """Return why the board does not answer, judged by what was received instead."""
        strange = self._strange
        if strange is not None and any(word in strange for word in (b"login:", b"Password:")):
            return troubles.login_shell(strange)
        if self._heard:
            return troubles.HALF_HEARD
        return troubles.SILENT if strange is None else troubles.stranger(strange)


def _restarted(event: Event) -> bool:
    """Return whether the event means that the board was reset and lost all its settings."""
    return isinstance(event, BootloaderPrompt | BootloaderVersion | InitDone)
