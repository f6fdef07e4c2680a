"""Checks of a Raspberry Pi: its power, clock and reset pin, and the port to the Build HAT."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from app.features.build_hat.machine import Machine
from app.tools.doctor.finding import PROBLEM, Finding, ok, problem, warning
from robot.hat.serial_port import find_device
from robot.hat.start.reset_line import ONE_WIRE_OFF, GpioResetLine, ResetError
from robot.hat.wire.ports import other_ports, port_names

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
ON = "sudo raspi-config nonint do_serial_hw 0; then sudo reboot"
CONSOLE_OFF = "sudo raspi-config nonint do_serial_cons 1; then sudo reboot"
GETTY_OFF = "sudo systemctl disable --now serial-getty@"
"""Ends a login shell that a service has started although the console is off."""
PERMISSION = "sudo usermod -aG dialout $USER; then log in again"
BOOT = ("/boot/firmware/config.txt", "/boot/config.txt")
"""Paths of the Pi's configuration: since Bookworm, and before."""
RESET_GPIO = "4"
"""The pin that resets the Build HAT; it is also the default pin of 1-Wire."""
HEADER_PORTS = {"serial0", "ttyS0", "ttyAMA0"}
"""Possible names of the header's serial port, used if the device does not exist."""


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
    try:
        GpioResetLine(devices=machine.at("/dev")).check()
    except ResetError as error:
        return warning(
            f"The Build HAT cannot be reset, as it must be after another firmware: {error.problem}",
            error.cure,
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


def check_wire(machine: Machine, setting: str) -> Iterator[Finding]:
    """Check that the port exists, and that only this program uses it.

    Args:
        setting: the requested device, or ``auto``.
    """
    if sys.platform == "win32":
        yield listed_port(setting, port_names())
        return
    device = device_of(machine, setting)
    yield from _port(machine, device, device_of(machine, "auto"))
    if model(machine):
        yield console(machine, device)
        yield one_wire(machine)


def listed_port(setting: str, names: Sequence[str]) -> Finding:
    """Check a port by the names of those that the system lists, as COM3."""
    if setting == "auto":
        return problem("A Build HAT is on a Raspberry Pi", other_ports("COM3"))
    if setting.upper() not in names:
        return problem(f"There is no serial port {setting}", other_ports("COM3"))
    return ok(f"Serial port {setting}")


def device_of(machine: Machine, setting: str) -> str:
    """Return the device that a setting stands for."""
    return find_device(machine.at(MODEL)) if setting == "auto" else setting


def usable(findings: list[Finding]) -> bool:
    """Whether it is worth opening the port."""
    return all(
        finding.level != PROBLEM or finding.cure.startswith((CONSOLE_OFF, GETTY_OFF))
        for finding in findings
    )


def _port(machine: Machine, device: str, right: str) -> Iterator[Finding]:
    path = machine.at(device)
    if not path.exists():
        yield problem(f"There is no serial port {device}", _cure_of_no_port(machine, device, right))
        return
    if _leads_to_another(machine, device, right):
        yield problem(
            f"{device} is another connector of this {model(machine)}", f"use {right}, or none"
        )
        return
    if not machine.may_use(path):
        yield problem(f"No permission to open {device}", PERMISSION)
        return
    users = list(users_of(machine, path))
    if users:
        yield problem(
            f"{device} is in use by {', '.join(users)}",
            "end that program; if it is brickpose as a service: sudo systemctl stop brickpose",
        )
        return
    yield ok(f"Serial port {device}")


def _cure_of_no_port(machine: Machine, device: str, right: str) -> str:
    if not model(machine):
        return "on a Raspberry Pi it comes with the Build HAT; else --serial-port names it"
    if device != right:
        return f"use {right}, or none"
    return ON


def _leads_to_another(machine: Machine, device: str, right: str) -> bool:
    """Whether the device is the debug connector of a Pi 5; there /dev/serial0 is a link to it."""
    if not model(machine) or right != "/dev/ttyAMA0":
        return False
    return machine.at(device).resolve().name == "ttyAMA10"


def users_of(machine: Machine, path: Path) -> Iterator[str]:
    """Yield the names of other programs that have a device open, as far as this user may see."""
    device = path.resolve()
    for process in machine.processes():
        try:
            open_files = [link.resolve() for link in (process / "fd").iterdir()]
        except OSError:
            continue  # another user's process, or one that has just ended
        # A process that also has the master end of a pseudo-terminal open is the emulator.
        if device in open_files and not any(file.name == "ptmx" for file in open_files):
            name = machine.text(f"/proc/{process.name}/comm") or "a program"
            yield f"{name} (process {process.name})"


def console(machine: Machine, device: str) -> Finding:
    """Check that neither the kernel nor a login shell also uses the port."""
    names = _names(machine, device)
    given = set(re.findall(r"console=(\w+)", machine.text("/proc/cmdline")))
    talks = f"A login console talks on {device}, into the Build HAT"
    if given & names:
        return problem(talks, CONSOLE_OFF)
    if port := _login_shell(machine, names):
        return problem(talks, f"{GETTY_OFF}{port}")
    return ok("No console on the serial port")


def _names(machine: Machine, device: str) -> set[str]:
    """Return all names of the port."""
    path = machine.at(device)
    if not path.exists():
        return HEADER_PORTS
    names = {Path(device).name, path.resolve().name}
    main = machine.at("/dev/serial0")
    if main.exists() and main.resolve() == path.resolve():
        names.add("serial0")
    return names


def _login_shell(machine: Machine, names: set[str]) -> str | None:
    """Return the name of the port at which an agetty waits; None if none does.

    The agetty is root's, so that only its command line can be read.
    """
    for process in machine.processes():
        words = machine.text(f"/proc/{process.name}/cmdline").split("\0")
        ports = names & {word.removeprefix("/dev/") for word in words}
        if words[0].endswith("agetty") and ports:
            return ports.pop()
    return None


def one_wire(machine: Machine) -> Finding:
    """Check that 1-Wire does not use the pin that resets the Build HAT."""
    lines = "\n".join(machine.text(path) for path in BOOT)
    for options in re.findall(r"^\s*dtoverlay=w1-gpio(?:-pullup|-pi5)?(\S*)", lines, re.MULTILINE):
        pin = re.search(r"gpiopin=(\d+)", options)
        if pin is None or pin[1] == RESET_GPIO:
            return problem("1-Wire has taken the Build HAT's reset pin (GPIO 4)", ONE_WIRE_OFF)
    return ok("1-Wire is off")
