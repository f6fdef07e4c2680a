"""The pin that resets the Build HAT; a reset stops all motors, and the firmware is lost."""

from __future__ import annotations

import errno
import importlib
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robot.errors import BrickPoseError

RESET_NAMES = ("GPIO4", "GPIO_GCLK")
"""What kernels call the reset's line; the second name is that of older ones."""
BOOT0_NAME = "GPIO22"
"""The line that is low while the board resets."""
CONSUMER = "brickpose"
"""Who holds the lines, for the kernel's lists (``gpioinfo``)."""
PULSE_S = 0.01

INSTALL = "pip install 'gpiod>=2'"
GROUP = "sudo usermod -aG gpio $USER; then log in again"
ONE_WIRE_OFF = "sudo raspi-config nonint do_onewire 1; then sudo reboot"
ONE_WIRE = ("onewire", "w1")
"""How the names begin under which the kernel's 1-Wire holds a line."""


class ResetError(BrickPoseError, RuntimeError):
    """The board cannot be reset by its pin; the message says what to do."""

    def __init__(self, problem: str, cure: str = "") -> None:
        super().__init__(f"{problem}; {cure}" if cure else problem)
        self.problem = problem
        self.cure = cure


@dataclass(frozen=True, slots=True)
class HeaderLines:
    """The lines of a Pi's header that go to the board."""

    chip: Path
    """The kernel's device; which one it is differs between models of the Pi."""
    reset: str

    @property
    def lines(self) -> tuple[str, str]:
        """Their names; BOOT0 comes first, as it has to be low when the reset begins."""
        return BOOT0_NAME, self.reset


class GpioResetLine:
    """The pin on a Pi's header, through the kernel's library; it is held only for the pulse."""

    def __init__(
        self, sleep: Callable[[float], None] = time.sleep, devices: Path = Path("/dev")
    ) -> None:
        """``devices`` has the kernel's ``gpiochip*``."""
        self._sleep = sleep
        self._devices = devices

    def pulse(self) -> None:
        """Reset the board; takes 20 ms.

        Raises:
            ResetError: there is no such pin, or it may not be driven now.
        """
        gpiod, header = self._locate()
        line, settings = gpiod.line, gpiod.LineSettings
        low = settings(direction=line.Direction.OUTPUT, output_value=line.Value.INACTIVE)
        free = settings(direction=line.Direction.INPUT)
        with gpiod.Chip(str(header.chip)) as chip:
            try:
                request = chip.request_lines(dict.fromkeys(header.lines, low), consumer=CONSUMER)
            except OSError as error:
                raise _refused(chip, header, error) from error
            with request:
                self._sleep(PULSE_S)
                request.set_value(header.reset, line.Value.ACTIVE)
                self._sleep(PULSE_S)
                # The kernel leaves a line as it was driven last.
                request.reconfigure_lines(dict.fromkeys(header.lines, free))

    def check(self) -> None:
        """Find the pin and see whether it is free, without driving it.

        Raises:
            ResetError: ``pulse`` would fail.
        """
        gpiod, header = self._locate()
        with gpiod.Chip(str(header.chip)) as chip:
            if held := _held(chip, header):
                raise held

    def _locate(self) -> tuple[Any, HeaderLines]:
        """Return the library and where the lines are."""
        chips = sorted(self._devices.glob("gpiochip*"))
        if not chips:
            raise ResetError(
                f"there is no {self._devices / 'gpiochip*'}", "only a Raspberry Pi resets the board"
            )
        gpiod = _library()
        header = _header(gpiod, chips)
        if header is None:
            raise ResetError(
                f"no {self._devices / 'gpiochip*'} has the lines {RESET_NAMES[0]} and {BOOT0_NAME}",
                "only a Raspberry Pi with a current system resets the board: sudo apt full-upgrade",
            )
        return gpiod, header


def _library() -> Any:
    """Import the kernel's library, late, because a computer without pins does not need it."""
    try:
        gpiod = importlib.import_module("gpiod")
    except ImportError as error:
        raise ResetError("the reset pin needs gpiod", INSTALL) from error
    if not hasattr(gpiod, "LineSettings"):
        raise ResetError("the reset pin needs version 2 of gpiod", INSTALL)
    return gpiod


def _header(gpiod: Any, chips: Iterable[Path]) -> HeaderLines | None:
    """Find the chip that has the lines."""
    forbidden = None
    for path in chips:
        try:
            with gpiod.Chip(str(path)) as chip:
                for reset in RESET_NAMES:
                    header = HeaderLines(path, reset)
                    if all(_has(chip, name) for name in header.lines):
                        return header
        except PermissionError as error:
            forbidden = error
        except OSError:
            continue  # it is not a chip, or is gone
    if forbidden is not None:
        raise ResetError("no permission for the reset pin", GROUP) from forbidden
    return None


def _has(chip: Any, name: str) -> bool:
    try:
        chip.line_offset_from_id(name)
    except OSError as error:
        if error.errno == errno.ENOENT:
            return False
        raise
    return True


def _refused(chip: Any, header: HeaderLines, error: OSError) -> ResetError:
    """Say why the kernel does not hand out the lines."""
    held = _held(chip, header) if error.errno == errno.EBUSY else None
    return held or ResetError(
        f"the reset pin cannot be driven: {error}", "restart the Pi: sudo reboot"
    )


def _held(chip: Any, header: HeaderLines) -> ResetError | None:
    """Say who holds one of the lines; None if both are free."""
    for name in header.lines:
        info = chip.get_line_info(name)
        if info.used:
            holder = info.consumer or "another program"
            one_wire = holder.startswith(ONE_WIRE)
            cure = f"switch 1-Wire off: {ONE_WIRE_OFF}" if one_wire else "end the program"
            return ResetError(f"{name} is held by {holder!r}", cure)
    return None
