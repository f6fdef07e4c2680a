"""The serial ports of a computer that is no Raspberry Pi."""

from __future__ import annotations


def port_names() -> list[str]:
    """Return the names of the ports that the system lists."""
    from serial.tools import list_ports  # type: ignore[import-untyped, unused-ignore]  # noqa: PLC0415

    return sorted(str(port.device) for port in list_ports.comports())


def other_ports(example: str) -> str:
    """Return the words that say how to choose a port, and which there are."""
    return f"--serial-port names one, as {example}; there is {', '.join(port_names()) or 'none'}"
