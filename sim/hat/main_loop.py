"""The firmware: its start, its command lines, its main loop of 1 ms and its 10 ms drive ticks."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

from sim.hat.commands import FirmwareRun, execute
from sim.hat.firmware.connection import Connection, SetupFault
from sim.hat.firmware.port import Port
from sim.hat.firmware.power import FaultWatch, Power
from sim.hat.firmware.reports import Writer
from sim.hat.lego_motor import LegoMotor
from sim.hat.plants import PORTS
from sim.hat.words import CommandWords

LONGEST = 256
"""Longest line [bytes]; further bytes are dropped until the CR."""

CR, BACKSPACE, DELETE = 0x0D, 0x08, 0x7F
COMMENT = b"#"
DRIVE_PERIOD = 10
"""Time between two runs of the controllers [ms]; those of all ports run together."""
LATE = 2
"""The firmware reports a pass of the main loop that takes longer than this [ms]."""
RECEIVE_RING = 8191
"""Capacity of the receive buffer [bytes]."""
STARTED = 225
"""Time at which the main loop begins [ms]."""
DROPPED_UNTIL = 11
"""Bytes received up to this time are dropped [ms]."""
START = (
    (1, "\r\nType help <RETURN> for help\r\n"),
    (11, "Initialising ports\r\n"),
    (111, "Resetting drivers: 0123\r\n"),
    (220, "Reading driver dumps: before port_initdriver(): 0123\r\n"),
    (220, "Reading driver dumps: after port_initdriver(): 0123\r\n"),
    (225, "Done initialising ports\r\n"),
)
"""Times after the start [ms] and what the firmware prints at them."""


def raw_text(byte: int) -> str:
    """Return a byte as text that encodes to the same byte again, even if it is not valid UTF-8."""
    return bytes([byte]).decode("utf-8", "surrogateescape")


class Terminal:
    """Collects lines and executes them. Only a CR ends a line; a LF is an ordinary character."""

    __slots__ = ("_line", "_session")

    def __init__(self, session: FirmwareRun) -> None:
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
            execute(self._session, CommandWords(line))
            self.prompt()

    def _echo(self, text: str) -> None:
        if self._session.echo:
            self._session.write(text)


def version_text(version: int) -> str:
    """Return a version, which is its build time [s since 1970], followed by its date."""
    return f"{version} {datetime.fromtimestamp(version, UTC).isoformat()}"


class Firmware:
    """Takes bytes by ``receive``, writes text by ``write``; time passes in ``passed``."""

    def __init__(
        self,
        write: Writer,
        has_room: Callable[[], bool],
        power: Power,
        version: str,
        signature: bytes,
    ) -> None:
        """Begin at the first instruction.

        Args:
            has_room: whether that queue is less than half full.
            power: the board's supply and fault lines.
            version: number and date of the version, as the firmware prints them.
            signature: signature of the image (64 bytes).
        """
        self._write = write
        self._now = 0
        self._heard = bytearray()
        self._drive_due = STARTED + DRIVE_PERIOD
        self._faults = FaultWatch(power)
        self.ports = tuple(Port(number, write) for number in range(PORTS))
        self._modes = tuple(port.data for port in self.ports)
        self._connections = tuple(Connection(port, write, has_room) for port in self.ports)
        self._terminal = Terminal(FirmwareRun(self.ports, write, power, version, signature))

    def skip_start(self) -> None:
        """Continue as if it had run for long: it knows all plugged-in devices."""
        self._now = STARTED
        for connection in self._connections:
            connection.meet()

    def plug(self, port: int, device: LegoMotor) -> None:
        """Add a device, with power, at a port."""
        self._connections[port].plug(device)

    def unplug(self, port: int) -> None:
        """Remove the device at a port."""
        self._connections[port].unplug()

    def fail_setup(self, port: int, fault: SetupFault) -> None:
        """Make the setup of the next device on a port fail."""
        self._connections[port].fail_setup(fault)

    def fail_data(self, port: int, framing: int, checksum: int) -> None:
        """Set the numbers of errors in the data of the device on a port."""
        self._connections[port].fail_data(framing, checksum)

    def receive(self, data: bytes) -> None:
        """Take bytes from the line; they are processed when time passes."""
        self._heard += data[: max(RECEIVE_RING - len(self._heard), 0)]

    def passed(self, milliseconds: int, seconds: float) -> None:
        """Run one pass of the main loop.

        Args:
            milliseconds: time since the last pass.
            seconds: time of the board's clock.
        """
        before, self._now = self._now, self._now + milliseconds
        if before < STARTED:
            self._start(before)
            return
        if milliseconds > LATE:
            self._write(f"deltat={milliseconds:08X}\r\n")
        faults = self._faults.passed(milliseconds)
        if faults:
            self._write(faults)
        for connection in self._connections:
            connection.passed(self._now, seconds)
        while self._now >= self._drive_due:
            self._drive_due += DRIVE_PERIOD
            self._drive()
        if self._heard:
            data, self._heard = self._heard, bytearray()
            self._terminal.hear(bytes(data))

    def _start(self, before: int) -> None:
        for moment, text in START:
            if before < moment <= self._now:
                self._write(text)
        if self._now <= DROPPED_UNTIL:
            self._heard.clear()

    def _drive(self) -> None:
        for port in self.ports:
            port.run_drive(self._modes)
