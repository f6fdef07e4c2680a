"""The pin that resets the Build HAT; a reset stops all motors, and the firmware is lost."""

from __future__ import annotations

import importlib
import time
import warnings
from collections.abc import Callable
from typing import Any

from robot.errors import BrickPoseError

RESET_PIN = 4
"""BCM number."""
BOOT0_PIN = 22
"""BCM number; low while the board resets."""
PULSE_S = 0.01

CURE = "Install them: pip install gpiozero lgpio"


class ResetError(BrickPoseError, RuntimeError):
    """The board cannot be reset by its pin; the message says what to do."""


class GpioResetLine:
    """The pin on a Pi's header, through gpiozero; it is held only during the pulse."""

    def __init__(self, sleep: Callable[[float], None] = time.sleep) -> None:
        self._sleep = sleep

    def pulse(self) -> None:
        """Reset the board; takes 20 ms."""
        try:
            # Imported late, because a computer without pins does not need it.
            gpiozero: Any = importlib.import_module("gpiozero")
        except ImportError as error:
            raise ResetError(f"the reset pin needs gpiozero and lgpio. {CURE}") from error
        try:
            # gpiozero warns of each missing backend for the pins; if all are missing, it raises.
            warnings.filterwarnings("ignore", module="gpiozero")
            self._pulse(gpiozero.DigitalOutputDevice)
        except gpiozero.GPIOZeroError as error:
            raise ResetError(f"no pin to reset the board: {error} {CURE}") from error
        # The backends of gpiozero raise errors of their own.
        except Exception as error:
            raise ResetError(
                f"pin {RESET_PIN} is not free: {error}; switch 1-Wire off: sudo raspi-config, "
                "Interface Options, 1-Wire"
            ) from error

    def _pulse(self, output: Callable[[int], Any]) -> None:
        """Set BOOT0 low, and RESET low and then high; then release both."""
        with output(BOOT0_PIN) as boot0, output(RESET_PIN) as reset:
            boot0.off()
            reset.off()
            self._sleep(PULSE_S)
            reset.on()
            self._sleep(PULSE_S)
