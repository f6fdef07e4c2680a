"""Single precision, as in the firmware's float variables."""

from __future__ import annotations

import math
from ctypes import c_float

SMALLEST_NORMAL = 2.0**-126
"""A single below this is printed as zero."""


def single(value: float) -> float:
    """Return the nearest IEEE 754 single, or an infinity beyond its range."""
    return c_float(value).value


def clamped(value: float, low: float, high: float) -> float:
    """Clip ``value`` to ``low`` first and then to ``high``, as the firmware does."""
    value = max(value, low)
    return min(value, high)


def float_text(value: float) -> str:
    """Format a single as the firmware does: 6 significant digits, with ``E`` outside 1e-2 to 1e6.

    The scaling uses single precision, so the last digit is the firmware's and not the nearest.
    """
    value = single(value)
    sign = "-" if math.copysign(1.0, value) < 0 else ""
    return sign + _magnitude_text(abs(value))


def _magnitude_text(value: float) -> str:
    if not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Inf"
    if value < SMALLEST_NORMAL:
        return "0.00000"
    digits, exponent = _mantissa(value)
    if exponent < -2 or exponent > 5:
        return f"{digits[0]}.{digits[1:]}E{exponent}"
    if exponent < 0:
        return f"0.{'0' * (-exponent - 1)}{digits}"
    return f"{digits[: exponent + 1]}.{digits[exponent + 1 :]}".removesuffix(".")


def _mantissa(value: float) -> tuple[str, int]:
    """Return six digits of a positive normal single, and the power of ten of the first digit."""
    exponent = 7
    while value < 1:
        value, exponent = single(value * 1e8), exponent - 8
    while value >= 1e8:
        value, exponent = single(value / 1e8), exponent + 8
    if value < 1e4:
        value, exponent = single(value * 1e4), exponent - 4
    if value < 1e6:
        value, exponent = single(value * 1e2), exponent - 2
    while value < 1e7:
        value, exponent = single(value * 10), exponent - 1
    rounded = int(single(value + 50))
    if rounded >= 10**8:
        rounded, exponent = 10**7, exponent + 1
    return f"{rounded // 100:06d}", exponent
