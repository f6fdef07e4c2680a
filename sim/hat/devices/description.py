"""The firmware's listing of what a device reports about itself."""

from __future__ import annotations

from collections.abc import Iterator

from sim.hat.devices.device import Device, Mode

BAUD = 115200
HARDWARE_VERSION = 0x00000004
SOFTWARE_VERSION = 0x10000000


def active_description(device: Device, port: int) -> str:
    """Return the listing of an active device at a port, 0 to 3: lines that end in CR LF.

    All smallest values are 0, because the firmware converts negative floats to unsigned numbers.
    ``nmodes`` is the highest mode number, not the number of modes.
    """
    lines = [
        f"P{port}: connected to active ID {device.type_id:02X}",
        f"type {device.type_id:02X}",
        f"  nmodes ={len(device.modes) - 1}",
        "  nview  =3",
        f"  baud   ={BAUD}",
        f"  hwver  ={HARDWARE_VERSION:08X}",
        f"  swver  ={SOFTWARE_VERSION:08X}",
    ]
    for number, mode in enumerate(device.modes):
        lines += _mode(number, mode)
    for slot, modes in enumerate(device.combinations):
        lines.append(f"  C{slot}: " + "+".join(f"M{mode}" for mode in modes))
    speed, position = device.pid_defaults
    lines.append("     speed PID: " + " ".join(f"{word:08X}" for word in speed))
    lines.append("  position PID: " + " ".join(f"{word:08X}" for word in position))
    return "".join(line + "\r\n" for line in lines)


def _mode(number: int, mode: Mode) -> Iterator[str]:
    yield f"  M{number} {mode.name} SI = {mode.unit}"
    yield f"    format count={mode.count} type={mode.type:d} chars={mode.chars} dp={mode.dp}"
    ranges = (("RAW", mode.raw), ("PCT", mode.pct), ("SI", mode.si))
    yield "    " + "    ".join(f"{name}: {0:08X} {top:08X}" for name, top in ranges)
