"""Transmitters of the serial line at 115200 baud, one for each direction, and its noise.

A byte takes 86.8 us; buffers can fill; noise spoils bytes.
"""

from __future__ import annotations

import random

BYTES_PER_SECOND = 11_520.0
"""115200 baud, with a start and a stop bit for every eight bits."""

RING = 8192
"""Size of the firmware's output ring buffer; one byte of it always stays empty."""


class _Wire:
    """Sends queued bytes one after the other; the first byte also takes its time."""

    def __init__(self) -> None:
        self._queue = bytearray()
        self._passed = 0.0
        """Share of the current byte that has been sent."""

    def __len__(self) -> int:
        return len(self._queue)

    def put(self, data: bytes) -> None:
        """Add bytes to the end of the queue."""
        self._queue += data

    def advance(self, seconds: float) -> bytes:
        """Let time pass [s]; return the bytes that have been sent completely."""
        if not self._queue:
            return b""
        self._passed += seconds * BYTES_PER_SECOND
        # The small term lets steps that add up to a byte send it, in spite of rounding.
        count = min(int(self._passed + 1e-6), len(self._queue))
        passed = bytes(self._queue[:count])
        del self._queue[:count]
        # Idle time does not count for later bytes.
        self._passed = self._passed - count if self._queue else 0.0
        return passed

    def clear(self) -> None:
        """Drop all queued bytes, and the byte that is being sent."""
        self._queue.clear()
        self._passed = 0.0


class Transmitter(_Wire):
    """Board to host: bytes that do not fit into the ring buffer are lost without notice."""

    def put(self, data: bytes) -> None:
        """Queue as many of the bytes as the ring buffer has room for."""
        super().put(data[: max(RING - 1 - len(self), 0)])

    @property
    def at_least_half_full(self) -> bool:
        """Whether the buffer is at least half full, so that reports have to wait."""
        return len(self) >= RING // 2


class Receiver(_Wire):
    """Host to board: bytes that the host wrote wait in the host's buffers until they are sent."""


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
