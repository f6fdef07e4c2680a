"""Commands of the Build HAT's firmware and bootloader as bytes.

A command line ends in one CR; LF would poison the next line, and more than 256 characters are cut
without a word. All of a line is executed between two 10 ms ticks of the motors, so what belongs
together stands in one line. Ports are 0 to 3 (A to D).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping

LONGEST = 256
"""Characters of a line that the firmware keeps; the CR is counted, to be safe."""

PORTS = range(4)
EXPONENT = re.compile(r"(?:^|[ ;])[+-]?[0-9]*\.?[0-9]*[0-9.][eE][+-]?[0-9]")
STX, ETX, CR = b"\x02", b"\x03", b"\r"


class LineError(ValueError):
    """What should be a command line is none."""


def line(*parts: str) -> bytes:
    """One command line of these commands.

    Raises:
        LineError: not printable ASCII, a number with an exponent, or above 256 bytes.
    """
    text = ";".join(parts)
    if not (text.isascii() and text.isprintable()):
        raise LineError(f"{text!r} is not a line; valid are printable ASCII characters")
    if EXPONENT.search(text):
        raise LineError(f"{text!r}: the firmware knows no exponents; valid is 0.00001")
    if len(text) >= LONGEST:
        raise LineError(f"a line has {len(text) + 1} bytes; valid are at most {LONGEST}")
    return text.encode("ascii") + CR


def fixed(value: float, places: int) -> str:
    """A number as the firmware reads it, in as few characters as possible: ``-.5``, ``0``, ``20``.

    Raises:
        LineError: NaN or infinite.
    """
    if not math.isfinite(value):
        raise LineError(f"{value} is no number for the firmware; valid are finite ones")
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
    """Ask what is at the four ports."""
    return line("list")


def supply() -> bytes:
    """Ask for the supply's voltage."""
    return line("vin")


def clear_faults() -> bytes:
    """Forget the motor drivers' faults."""
    return line("clear_faults")


def echo_off_and_quiet() -> bytes:
    """End all reports, traces and echoes that an earlier program left on."""
    return line(*(f"port {port};select" for port in PORTS), "echo 0", "debug 0")


def set_up_motor(
    port: int,
    report_ms: int,
    limit: float,
) -> bytes:
    """Make a motor stand, and let it report speed, position and absolute position.

    All settings of a port are lost with its device, so send this for each ``Connected``. The
    drive is put to zero before the limit of 0.1 is lifted; ``select`` sets the report period to
    100 ms, so the period comes after it.

    Args:
        port: 0 to 3.
        report_ms: report period [ms].
        limit: highest duty, 0 to 1.
    """
    return line(
        f"port {_port(port)};pwm;off",
        f"port_plimit {fixed(limit, 3)}",
        "pwmparams 0 0",  # an even duty, however small; no whole 10 ms pulses instead
        "combi 0 1 0 2 0 3 0;select 0",
        f"selrate {report_ms}",
    )


def pulses(duties: Mapping[int, float], seconds: float) -> bytes:
    """Drive ports for a time, at the end of which the firmware itself sets them to zero.

    Sent again before the end it goes on without a gap. The two short names are those that are
    first in the firmware's table, so that two motors 100 times a second stay under half of the
    link: port and set.

    Args:
        duties: set-point by port; a duty from -1 to 1 where the port is in direct drive.
        seconds: at least 0.02.
    """
    length = fixed(seconds, 3)
    return line(
        *(f"p {_port(port)};s pulse {fixed(duty, 3)} 0 {length} 0" for port, duty in duties.items())
    )


def stop(ports: Iterable[int] = PORTS) -> bytes:
    """Brake, from whatever drive mode and set-point, all ports in one tick.

    ``pwm`` alone would drive with the old set-point, and ``off`` alone would not leave a closed
    loop; in one line they are safe.
    """
    return line(*(f"port {_port(port)};pwm;off" for port in ports))


def clear() -> bytes:
    """Bootloader: forget the image."""
    return line("clear")


def load(length: int, checksum: int) -> bytes:
    """Bootloader: an image of that length [bytes] and sum follows as ``payload``."""
    return line(f"load {length} {checksum}")


def signature(length: int) -> bytes:
    """Bootloader: a signature of that length [bytes] follows as ``payload``."""
    return line(f"signature {length}")


def payload(data: bytes) -> bytes:
    """Bootloader: what was announced, 0.1 s after the announcement; any bytes."""
    return STX + data + ETX + CR


def reboot() -> bytes:
    """Bootloader: check the image and run it."""
    return line("reboot")


def _port(port: int) -> int:
    if port not in PORTS:
        raise LineError(f"there is no port {port}; valid are 0 to 3")
    return port
