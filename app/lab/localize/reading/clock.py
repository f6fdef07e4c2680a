"""Whether a topic's stamps go on as the recorder's clock does."""

from __future__ import annotations

JUMP_S = 10.0
"""A stamp that is off by more is a mistake: no message is under way for so long [s]."""

SET = 10
"""So many mistakes in a row, all alike, are a clock that was set."""


class Clock:
    """Of one topic. A single stamp from elsewhere must not make all that follow seem old."""

    def __init__(self) -> None:
        self._ahead: float | None = None
        """Of the recorder's clock, at the last stamp that fitted [s]."""
        self._elsewhere = 0.0
        self._mistakes = 0

    def fits(self, stamp: float, logged: float) -> bool:
        """Whether a stamp [s] can be that of a message recorded then [s]."""
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
