"""Names of generated fields, as ``generated-17``: read by whoever only has to know one."""

from __future__ import annotations

import re

PREFIX = "generated-"
MAX_SEED = 2**32 - 1


def generated_seed(name: str) -> int | None:
    """Return the seed in a name such as ``generated-17``; None for any other name."""
    match = re.fullmatch(rf"{PREFIX}(0|[1-9]\d{{0,9}})", name)
    seed = int(match[1]) if match else None
    return seed if seed is not None and seed <= MAX_SEED else None
