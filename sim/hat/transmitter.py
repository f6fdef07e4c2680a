"""The serial line's two directions at 115200 baud: a byte takes 86.8 us, and rings fill up."""

from __future__ import annotations

BYTES_PER_SECOND = 11_520.0
"""115200 baud with a start and a stop bit to every eight."""

RING = 8192
"""Size of the firmware's output ring; one place of it always stays empty."""


class _Wire:
    """Lets queued bytes through one after the other; the first one takes its time too."""

    def __init__(self) -> None:
        self._queue = bytearray()
        self._passed = 0.0
        """How much of the byte that is under way has passed."""

    def __len__(self) -> int:
        return len(self._queue)

    def put(self, data: bytes) -> None:
        """Queue bytes behind those that wait."""
        self._queue += data

    def advance(self, seconds: float) -> bytes:
        """Let time pass [s]; returns the bytes that have passed whole."""
        if not self._queue:
            return b""
        self._passed += seconds * BYTES_PER_SECOND
        # Steps that add up to a byte shall pass it, whatever their rounding errors.
        count = min(int(self._passed + 1e-6), len(self._queue))
        passed = bytes(self._queue[:count])
        del self._queue[:count]
        # An idle line saves nothing up for later.
        self._passed = self._passed - count if self._queue else 0.0
        return passed

    def clear(self) -> None:
        """Lose everything that waits or is under way."""
        self._queue.clear()
        self._passed = 0.0


class Transmitter(_Wire):
    """Board to host: what does not fit into the ring is lost, byte by byte, without a notice."""

    def put(self, data: bytes) -> None:
        """Queue as much of it as the ring has room for."""
        super().put(data[: max(RING - 1 - len(self), 0)])

    @property
    def more_than_half_full(self) -> bool:
        """Whether reports have to wait."""
        return len(self) >= RING // 2


class Receiver(_Wire):
    """Host to board: what the host wrote waits, in its own buffers, for its turn on the line."""
