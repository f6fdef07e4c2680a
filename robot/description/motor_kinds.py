"""LEGO's motors: by which number they introduce themselves, what they are, what they can do."""

from __future__ import annotations

from dataclasses import dataclass

MOTORS = ("small angular", "medium angular", "large angular")
"""The kinds with an encoder that a joint of the description may name as its ``motor``."""


@dataclass(frozen=True, slots=True)
class MotorKind:
    """One type of motor."""

    type_id: int
    kind: str
    """One of ``MOTORS``."""
    lego_number: str
    """LEGO's number of the part."""
    free_speed: float
    """Speed at full duty and 7.2 V if there were no load and no friction [degree/s]."""
    time_constant: float
    """Of the speed after a step of the duty [s]."""
    friction: float
    """Duty that Coulomb friction takes while it turns."""
    breakaway: float
    """Duty that gets a standing motor to turn."""


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
"""By the number that they introduce themselves with; figures after Pybricks' measurements, which
LEGO's own sheets (tolerance 15 %) pass by 10 to 17 %."""

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
"""What else may be plugged in."""


def described(type_id: int) -> str:
    """What a device is called when people are told of it."""
    known = KINDS.get(type_id)
    if known is not None:
        return f"{known.kind} motor ({known.lego_number})"
    return OTHERS.get(type_id, f"device of type {type_id:02X}")
