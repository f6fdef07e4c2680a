"""Commands of the Build HAT's firmware and bootloader as bytes.

A command line ends in one CR; LF would spoil the next line. A line of more than 256 characters is
cut without a message. A whole line is executed between two 10 ms ticks of the motors, so commands
that belong together are in one line. Ports are 0 to 3 (A to D).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

from robot.errors import CommandError

LONGEST = 256
"""Number of characters of a line that the firmware keeps; to be safe, the CR is counted too."""

PORTS = range(4)
EXPONENT = re.compile(r"(?:^|[ ;])[+-]?[0-9]*\.?[0-9]*[0-9.][eE][+-]?[0-9]")
STX, ETX, CR = b"\x02", b"\x03", b"\r"


def line(*parts: str) -> bytes:
    """Return one command line of these commands.

    Raises:
        CommandError: the text is not printable ASCII, has a number with an exponent, or is longer
            than 256 bytes.
    """
    text = ";".join(parts)
    if not (text.isascii() and text.isprintable()):
        raise CommandError(f"{text!r} is not a line; valid are printable ASCII characters")
    if EXPONENT.search(text):
        raise CommandError(f"{text!r}: the firmware knows no exponents; valid is 0.00001")
    if len(text) >= LONGEST:
        raise CommandError(f"a line has {len(text) + 1} bytes; valid are at most {LONGEST}")
    return text.encode("ascii") + CR


def fixed(value: float, places: int) -> str:
    """Return a number in the firmware's format, as short as possible: ``-.5``, ``0``, ``20``.

    Raises:
        CommandError: the number is NaN or infinite.
    """
    if not math.isfinite(value):
        raise CommandError(f"{value} is no number for the firmware; valid are finite ones")
    text = f"{value:.{places}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    sign, size = ("-", text[1:]) if text[0] == "-" else ("", text)
    if size == "0":
        return "0"
    return sign + size.removeprefix("0") if size.startswith("0.") else text


def version() -> bytes:
    """Ask firmware or bootloader for its version."""
    return line("version")


def devices() -> bytes:
    """Ask which devices are at the four ports."""
    return line("list")


def supply() -> bytes:
    """Ask for the supply's voltage."""
    return line("vin")


def clear_faults() -> bytes:
    """Clear the motor drivers' faults."""
    return line("clear_faults")


def silence() -> bytes:
    """End all reports, traces and echoes that an earlier program left on."""
    return line(*(f"port {port};select" for port in PORTS), "echo 0", "debug 0")


def set_up_motor(
    port: int,
    report_ms: int,
    limit: float,
) -> bytes:
    """Stop a motor, and let it report speed, position and absolute position.

    A port loses all settings when its device is unplugged, so send this for each ``Connected``. The
    drive is set to zero before the limit of 0.1 is lifted. ``select`` sets the report period to
    100 ms, so the report period is set after it.

    Args:
        port: 0 to 3.
        report_ms: report period [ms].
        limit: highest duty, 0 to 1.
    """
    return line(
        f"port {_port(port)};pwm;off",
        f"port_plimit {fixed(limit, 3)}",
        "pwmparams 0 0",  # a constant duty, however small, not whole 10 ms pulses
        "combi 0 1 0 2 0 3 0;select 0",
        f"selrate {report_ms}",
    )


def pulses(duties: Mapping[int, float], seconds: float) -> bytes:
    """Drive ports for a time; at its end the firmware itself sets them to zero.

    If pulses are sent again before the end, the drive continues without a gap. ``p`` and ``s`` are
    short for port and set, the first such names in the firmware's table. With them, commands to two
    motors 100 times a second need less than half of the link.

    Args:
        duties: set-point by port; a duty from -1 to 1 where the port is in direct drive.
        seconds: at least 0.02.
    """
    length = fixed(seconds, 3)
    return line(
        *(f"p {_port(port)};s pulse {fixed(duty, 3)} 0 {length} 0" for port, duty in duties.items())
    )


def stop(ports: Iterable[int] = PORTS) -> bytes:
    """Brake all these ports in one tick, from any drive mode and set-point.

    ``pwm`` alone would drive with the old set-point, and ``off`` alone would not leave a closed
    loop. Together in one line they are safe.
    """
    return line(*(f"port {_port(port)};pwm;off" for port in ports))


def clear() -> bytes:
    """Bootloader: forget the image."""
    return line("clear")


def load(length: int, checksum: int) -> bytes:
    """Bootloader: announce an image of this length [bytes] and sum; ``payload`` sends it."""
    return line(f"load {length} {checksum}")


def signature(length: int) -> bytes:
    """Bootloader: announce a signature of this length [bytes]; ``payload`` sends it."""
    return line(f"signature {length}")


def payload(data: bytes) -> bytes:
    """Bootloader: send the announced data, any bytes; wait 0.1 s after the announcement."""
    return STX + data + ETX + CR


def reboot() -> bytes:
    """Bootloader: check the image and run it."""
    return line("reboot")


def _port(port: int) -> int:
    if port not in PORTS:
        raise CommandError(f"there is no port {port}; valid are 0 to 3")
    return port
