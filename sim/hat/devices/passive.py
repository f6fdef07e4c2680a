"""Device without a chip: the board identifies it by the resistors in its plug."""

from __future__ import annotations

from collections.abc import Sequence

from sim.hat.devices.device import CONNECT_SECONDS, DeviceError, Mode

MOTOR, TRAIN_MOTOR, BUTTON, LIGHT = 1, 2, 5, 8


class PassiveDevice:
    """A simple motor, a light or a button; it has no modes and never sends anything."""

    passive = True
    modes: Sequence[Mode] = ()
    combinations: Sequence[tuple[int, ...]] = ()
    pid_defaults: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())

    def __init__(self, type_id: int, *, connect_seconds: float = CONNECT_SECONDS) -> None:
        """Make a device with one of LEGO's passive type numbers, 1 to 11.

        Raises:
            DeviceError: no passive device has this number.
        """
        if not 1 <= type_id <= 11:
            raise DeviceError(f"no passive device has type {type_id}; valid are 1 to 11")
        self.type_id = type_id
        self.connect_seconds = connect_seconds
        self.responding = True
        self.pressed = False
        """Whether it is pressed; for a button, type 5."""

    def description(self, port: int) -> str:
        """Return what ``list`` prints for it: one line, with the type number in decimal."""
        return f"P{port}: connected to passive ID {self.type_id}\r\n"

    def power_up(self) -> None:
        """Do nothing: there is nothing to start."""

    def sample(self, current: float) -> bool:
        """Return False: it never has a message."""
        return False

    def read(self, mode: int) -> tuple[int | float, ...]:
        """Raise a ``DeviceError``: there are no modes."""
        raise DeviceError(f"passive device {self.type_id} has no modes, so none numbered {mode}")
