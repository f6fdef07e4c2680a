"""LEGO's motors: the type ids that they report, their kinds and their performance."""

from __future__ import annotations

from dataclasses import dataclass

MOTORS = ("small angular", "medium angular", "large angular")
"""The kinds with an encoder; a joint of the description names one of them as its ``motor``."""


@dataclass(frozen=True, slots=True)
class MotorKind:
    """One type of motor."""

    type_id: int
    kind: str
    """One of ``MOTORS``."""
    lego_number: str
    """LEGO's part number."""
    free_speed: float
    """Speed at full duty and 7.2 V without load and friction [degree/s]."""
    time_constant: float
    """Time constant of the speed after a step of the duty [s]."""
    friction: float
    """Duty that Coulomb friction takes while the motor turns."""
    breakaway: float
    """Duty at which a standing motor begins to turn."""


KINDS = {
    item.type_id: item
    for item in (
        MotorKind(0x41, "small angular", "45607", 1070.0, 0.035, 0.12, 0.135),
        MotorKind(0x30, "medium angular", "45603", 1100.0, 0.036, 0.13, 0.145),
        MotorKind(0x31, "large angular", "45602", 1000.0, 0.048, 0.055, 0.105),
        MotorKind(0x4B, "medium angular", "88018", 1100.0, 0.036, 0.13, 0.145),
        MotorKind(0x4C, "large angular", "88017", 1000.0, 0.048, 0.055, 0.105),
    )
}
"""Motor kinds by type id. The figures are from Pybricks' measurements; those of LEGO's own sheets
(tolerance 15 %) are 10 to 17 % higher."""

OTHERS = {
    0x01: "simple medium motor (45303): it has no encoder",
    0x02: "train motor (88011): it has no encoder",
    0x26: "medium linear motor (88008)",
    0x2E: "Technic large motor (88013)",
    0x2F: "Technic XL motor (88014)",
    0x3D: "colour sensor",
    0x3E: "distance sensor",
    0x3F: "force sensor",
    0x40: "light matrix",
}
"""Names of other devices that may be plugged in, by type id."""


def described(type_id: int) -> str:
    """Return the name of a device for messages."""
    known = KINDS.get(type_id)
    if known is not None:
        return f"{known.kind} motor ({known.lego_number})"
    return OTHERS.get(type_id, f"device of type {type_id:02X}")
