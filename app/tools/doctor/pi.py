"""Checks of the Raspberry Pi itself: its model, its power, its clock and the reset pin."""

from __future__ import annotations

from collections.abc import Iterator

from app.tools.doctor.finding import Finding, Machine, ok, warning

MODEL = "/proc/device-tree/model"

TROUBLES = {
    0: "its voltage is too low now",
    2: "it is slowed down now",
    3: "it is too hot now",
    16: "its voltage was too low since it was switched on",
    18: "it was slowed down since it was switched on",
    19: "it was too hot since it was switched on",
}
"""Bits printed by ``vcgencmd get_throttled`` (Raspberry Pi documentation, Raspberry Pi OS)."""


def check_pi(machine: Machine) -> Iterator[Finding]:
    """Check what only a Raspberry Pi has; on another computer only warn that it is not a Pi."""
    name = model(machine)
    if not name:
        yield warning(
            "This is no Raspberry Pi, so no Build HAT is on it",
            "none is needed for the one of brickpose emulate-hat",
        )
        return
    yield ok(name)
    yield from power(machine)
    yield reset_pin(machine)


def model(machine: Machine) -> str:
    """Return the Pi's model name; empty for another computer."""
    name = machine.text(MODEL)
    return name if name.startswith("Raspberry Pi") else ""


def power(machine: Machine) -> Iterator[Finding]:
    """Check that the Pi has enough power and is cool; yield nothing if that is not known."""
    said = machine.run(["vcgencmd", "get_throttled"])
    bits = _throttled(said)
    if bits is None:
        return
    troubles = [text for bit, text in TROUBLES.items() if bits >> bit & 1]
    if troubles:
        yield warning(
            f"The Pi is not well: {'; '.join(troubles)}",
            "a stronger supply at the Build HAT (8 V, 48 W) or a charged battery; when hot, a fan",
        )
    else:
        yield ok("The Pi has power enough and is cool")


def reset_pin(machine: Machine) -> Finding:
    """Check that the Build HAT can be reset, which is needed if it runs another firmware."""
    chips = sorted(machine.at("/dev").glob("gpiochip*"))
    if not chips:
        return warning("There is no /dev/gpiochip*: the Build HAT's reset pin is out of reach")
    if not any(machine.may_use(chip) for chip in chips):
        return warning(
            "No permission for the Build HAT's reset pin, which is needed for another firmware",
            "sudo usermod -aG gpio $USER; then log in again",
        )
    return ok("The Build HAT's reset pin is within reach")


def clock(machine: Machine) -> Iterator[Finding]:
    """Check that the clock is set; only a warning, since the robot drives by another clock."""
    said = machine.run(["timedatectl", "show", "--property=NTPSynchronized", "--value"])
    if said is None:
        return
    if said.strip() == "yes":
        yield ok("The clock is set by the network")
    else:
        yield warning(
            "The clock is not set by the network: dates of files may be wrong",
            "connect the network; sudo timedatectl set-ntp true",
        )


def _throttled(said: str | None) -> int | None:
    try:
        return int((said or "").strip().partition("=")[2], 16)
    except ValueError:
        return None
