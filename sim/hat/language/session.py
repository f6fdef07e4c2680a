"""State that command lines act on and leave for the next line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sim.hat.firmware.port import Port
from sim.hat.firmware.power import Power
from sim.hat.firmware.reports import Writer


@dataclass(slots=True)
class Session:
    """State of one run of the firmware for its commands; it stays when a client disconnects."""

    ports: Sequence[Port]
    write: Writer
    power: Power
    version: str
    """Number and date of the version."""
    signature: bytes
    """Signature of the running image (64 bytes)."""
    current: int = 0
    """Number of the port that commands act on, until another is named."""
    echo: int = 0

    @property
    def port(self) -> Port:
        """The port that commands act on."""
        return self.ports[self.current]
