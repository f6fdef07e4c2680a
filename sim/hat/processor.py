"""The board's processor: it runs the bootloader, or the firmware that the bootloader received."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping

from sim.hat.bootloader import Bootloader
from sim.hat.firmware.power import Power
from sim.hat.lego_motor import LegoMotor
from sim.hat.main_loop import Firmware, version_text
from sim.hat.transmitter import Transmitter

VERSION = 1737564117
"""Version of the firmware that is emulated."""

TICK = 0.001
"""Time step of the emulation [s]."""

VERSION_IN_IMAGE = re.compile(rb"\d{10} \d{4}-\d\d-\d\dT[0-9:]{8}\+00:00")


class Processor:
    """Takes bytes, writes text to the transmitter, and starts in the bootloader."""

    def __init__(
        self, transmitter: Transmitter, power: Power, devices: Mapping[int, LegoMotor]
    ) -> None:
        """Start.

        Args:
            transmitter: takes everything that the processor prints.
            power: the board's supply and fault lines.
            devices: the plugged-in devices by port; the board keeps it up to date.
        """
        self._transmitter = transmitter
        self._power = power
        self._devices = devices
        self.reset()

    def reset(self) -> None:
        """Return to the bootloader; the firmware and all queued output are lost."""
        self.firmware: Firmware | None = None
        self._stall = self._stalled = 0
        self._transmitter.clear()
        self._bootloader = Bootloader(self._transmitter.put)

    def run_warm(self, version: int) -> None:
        """Run a firmware that was loaded long ago and knows the devices."""
        self._transmitter.clear()
        signature = hashlib.sha512(str(version).encode()).digest()
        self._run(version_text(version), signature).skip_start()

    def stall(self, milliseconds: int) -> None:
        """Set the duration of the next pass of the firmware's main loop."""
        self._stall = milliseconds

    def passed(self, heard: bytes, seconds: float) -> None:
        """Advance by 1 ms, with the bytes received in it; ``seconds``: the board's clock."""
        if self.firmware is None:
            self._load(heard)
            return
        if heard:
            self.firmware.receive(heard)
        self._stalled += 1
        if self._stalled >= self._stall:
            self.firmware.passed(self._stalled, seconds)
            self._stall = self._stalled = 0

    def _load(self, heard: bytes) -> None:
        loader = self._bootloader
        for byte in heard:
            loader.receive(byte)
        loader.tick(TICK)
        if loader.rebooted:
            result = VERSION_IN_IMAGE.search(loader.image)
            self._run(
                result.group().decode() if result else version_text(VERSION), loader.signature
            )

    def _run(self, version: str, signature: bytes) -> Firmware:
        """Start a firmware, which switches the devices' supply off and on."""
        self.firmware = Firmware(self._write, self._has_room, self._power, version, signature)
        for port, device in self._devices.items():
            device.power_up()
            self.firmware.plug(port, device)
        return self.firmware

    def _write(self, text: str) -> None:
        # Echoed bytes may not be valid UTF-8; they are sent as they were received.
        self._transmitter.put(text.encode("utf-8", "surrogateescape"))

    def _has_room(self) -> bool:
        return not self._transmitter.at_least_half_full
