"""What command lines act on and what they leave behind for the next one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sim.hat.firmware.port import Port
from sim.hat.firmware.power import BY_SUPPLY, Power
from sim.hat.firmware.reports import Writer

TRACE_PAYLOADS, TRACE_CONTROLLERS = 8, 16
"""Bits of ``debug``."""


@dataclass(slots=True)
class Session:
    """One run of the firmware, as its commands see it; a client that leaves changes nothing."""

    ports: Sequence[Port]
    write: Writer
    power: Power
    version: str
    """Number and date."""
    signature: bytes
    """Of the image that runs (64)."""
    current: int = 0
    """The port that commands mean, until another is named."""
    echo: int = 0
    debug: int = 0
    light_mode: int = BY_SUPPLY

    @property
    def port(self) -> Port:
        """The port that commands mean."""
        return self.ports[self.current]

    def traces(self, bit: int) -> bool:
        """Whether a kind of debugging output is on."""
        return self.debug & bit != 0
