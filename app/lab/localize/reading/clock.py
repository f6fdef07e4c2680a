"""Check that a topic's stamps advance with the recorder's clock."""

from __future__ import annotations

JUMP_S = 10.0
"""A stamp is wrong if its offset jumps by more: no message is under way for so long [s]."""

SET = 10
"""After this many successive wrong stamps with about the same offset, the clock was set."""


class Clock:
    """The clock of one topic. A single wrong stamp must not make all later stamps seem old."""

    def __init__(self) -> None:
        self._ahead: float | None = None
        """Stamp minus the recorder's time, at the last stamp that fitted [s]."""
        self._elsewhere = 0.0
        self._mistakes = 0

    def fits(self, stamp: float, logged: float) -> bool:
        """Whether a stamp [s] fits the time at which the message was recorded [s]."""
        ahead = stamp - logged
        if self._ahead is None or abs(ahead - self._ahead) <= JUMP_S:
            self._ahead, self._mistakes = ahead, 0
            return True
        alike = self._mistakes > 0 and abs(ahead - self._elsewhere) <= JUMP_S
        self._mistakes = self._mistakes + 1 if alike else 1
        self._elsewhere = ahead
        if self._mistakes < SET:
            return False
        self._ahead, self._mistakes = ahead, 0
        return True
