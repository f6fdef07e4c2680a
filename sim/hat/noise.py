"""Noise on a serial line: bytes are lost, doubled, zeroed or changed by one bit."""

from __future__ import annotations

import random


class Noise:
    """Adds random faults to bytes; the same seed gives the same faults."""

    def __init__(self, seed: int, kinds: int = 4) -> None:
        """Use the first ``kinds`` kinds of faults of: lost, doubled, zeroed, changed by one bit."""
        self._kinds = kinds
        self.probability = 0.0
        """Probability of a fault in each byte."""
        self._random = random.Random(seed)

    def over(self, data: bytes) -> bytes:
        """Return what arrives when bytes are sent."""
        if self.probability <= 0:
            return data
        return b"".join(self._byte(byte) for byte in data)

    def _byte(self, byte: int) -> bytes:
        if self._random.random() >= self.probability:
            return bytes([byte])
        kind = self._random.randrange(self._kinds)
        if kind == 0:
            return b""
        if kind == 1:
            return bytes([byte, byte])
        return b"\0" if kind == 2 else bytes([byte ^ 1 << self._random.randrange(8)])
