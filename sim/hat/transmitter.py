"""The two directions of the serial line at 115200 baud: a byte takes 86.8 us; buffers can fill."""

from __future__ import annotations

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
