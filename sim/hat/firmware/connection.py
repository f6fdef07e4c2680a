"""Connection of a port: it detects a device, sets it up, receives its data and notices its loss."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from enum import Enum

from sim.hat.firmware.port import DeviceLink, Port
from sim.hat.firmware.reports import Writer
from sim.hat.lego_motor import LegoMotor

PROBE = 98
"""Duration of one probe of a device's resistors [ms]: 10 ms, then eight times 11 ms."""

LISTENING = 100
"""How long an active device holds its line low [ms]."""

SETUP_SILENCE = 2000
"""Longest pause in a device's messages during setup [ms]."""

DATA_SILENCE = 500
"""Longest pause between two data messages [ms]."""

AFTER_ACKNOWLEDGE = 120
"""Time from the device's last message at the low baud rate to the change of baud rate [ms]."""

FAULT_AFTER = 50
"""Time from the start of the setup until a framing or checksum error shows [ms]."""

MOST_ERRORS = 5


class SetupFault(Enum):
    """How the setup of a device can fail; the value is the firmware's text."""

    FRAMING = "framing error"
    CHECKSUM = "checksum error"
    SILENCE = "timeout during setup phase"


BROKEN = (SetupFault.FRAMING, SetupFault.CHECKSUM)


class Connection:
    """State machine of a port; each step yields the time until the next one [ms]."""

    def __init__(
        self,
        port: Port,
        write: Writer,
        has_room: Callable[[], bool],
    ) -> None:
        """Start without a device.

        Args:
            write: takes the lines that it prints.
            has_room: whether the transmit ring is less than half full.
        """
        self._port = port
        self._write = write
        self._has_room = has_room
        self._plugged: DeviceLink | None = None
        self._fault: SetupFault | None = None
        self._errors = (0, 0)
        self._now = 0
        self._due = 0
        self._seconds = 0.0
        self._life = self._search()

    def plug(self, device: LegoMotor) -> None:
        """Plug in a device that has power, replacing any other."""
        self._plugged = DeviceLink(device)

    def unplug(self) -> None:
        """Remove the device."""
        self._plugged = None

    def meet(self) -> None:
        """Continue as if the device had been set up before: start with receiving its data."""
        if self._plugged is None:
            return
        self._port.known = self._plugged.device
        self._port.connected = True
        self._port.link = self._plugged
        self._life = self._known(self._plugged)

    def fail_setup(self, fault: SetupFault) -> None:
        """Make the next setup of a device fail."""
        self._fault = fault

    def fail_data(self, framing: int, checksum: int) -> None:
        """Set the numbers of errors in the data of the connected device."""
        self._errors = (framing, checksum)

    def passed(self, current: int, seconds: float) -> None:
        """Advance to ``current`` [ms] of the firmware's clock; ``seconds``: the board's clock."""
        if current >= self._due:
            self._now, self._seconds = current, seconds
            self._due = current + next(self._life)

    def _search(self) -> Iterator[int]:
        """Search for devices forever."""
        while True:
            self._vacate()
            yield PROBE
            if self._hears():
                yield from self._active()

    def _known(self, link: DeviceLink) -> Iterator[int]:
        yield 1
        yield from self._listen(link)
        yield from self._search()

    def _vacate(self) -> None:
        if self._port.connected:
            self._say("disconnected")
        self._port.connected = False
        self._port.known = None
        self._port.reset_drive()

    def _hears(self) -> bool:
        return self._plugged is not None and self._plugged.device.responding

    def _active(self) -> Iterator[int]:
        """Handle a device, from its first low line to the end of the connection."""
        yield LISTENING
        link = self._plugged
        if link is None or not self._hears():
            return
        self._say("connecting to active device")
        self._port.forget_device()
        failure = yield from self._introduce(link)
        if failure is not None:
            self._say(f"{failure.value}: disconnecting")
            return
        self._write("set baud rate to 115200\r\n")
        yield 1
        self._establish(link)
        yield from self._listen(link)

    def _introduce(self, link: DeviceLink) -> Generator[int, None, SetupFault | None]:
        """Run the setup, at 2400 baud; return how it failed, or None."""
        fault, self._fault = self._fault, None
        start = heard = self._now
        end = start + max(round(link.device.connect_seconds * 1000) - AFTER_ACKNOWLEDGE - 1, 10)
        while self._now < end or heard < self._now:
            yield 1
            talks = link is self._plugged and link.device.responding
            if talks and fault is not SetupFault.SILENCE:
                heard = self._now
            if fault in BROKEN and self._now - start >= FAULT_AFTER:
                return fault
            if self._now - heard > SETUP_SILENCE:
                return SetupFault.SILENCE
        yield AFTER_ACKNOWLEDGE
        return None

    def _establish(self, link: DeviceLink) -> None:
        port, device = self._port, link.device
        port.selection.clear()
        port.known, port.link, port.connected = device, link, True
        self._errors = (0, 0)
        self._write(port.describe())
        self._say(f"established serial communication with active ID {device.type_id:02X}")

    def _listen(self, link: DeviceLink) -> Iterator[int]:
        """Receive data, at 115200 baud, until the device is silent for too long or has errors."""
        port, selection = self._port, self._port.selection
        heard = self._now
        while True:
            if self._receive(link):
                heard = self._now
            elif sum(self._errors) > MOST_ERRORS:
                framing, checksum = self._errors
                self._say(f"too many errors ({framing}+{checksum}): disconnecting")
                break
            elif self._now - heard > DATA_SILENCE:
                self._say("timeout during data phase: disconnecting")
                break
            if selection.is_due(self._now, self._has_room):
                port.report()
            yield 1
        selection.clear()
        port.link = None

    def _receive(self, link: DeviceLink) -> bool:
        """Receive a message, if there is one; return whether there was."""
        if link is not self._plugged or not link.device.sample(self._seconds):
            return False
        payload = link.message()
        if not payload:
            return False
        self._port.receive(payload, link.mode, self._now)
        return True

    def _say(self, text: str) -> None:
        self._write(f"P{self._port.number}: {text}\r\n")
