"""Makes whoever guesses tokens wait for the next guess; a right token is never asked to."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass

FREE_GUESSES = 5
"""Wrong tokens from one address before it has to wait."""
LONGEST_WAIT = 60.0
"""The wait doubles from a second to this [s]."""
MOST_ADDRESSES = 1000
"""Addresses whose wrong tokens are remembered."""


@dataclass
class _Guesses:
    """Wrong tokens of one address."""

    count: int
    last: bytes
    until: float
    """End of the wait, on the clock of the caller [s]."""


class Guessing:
    """Makes who tries tokens wait longer and longer; addresses are independent."""

    def __init__(self) -> None:
        self._guesses: OrderedDict[str, _Guesses] = OrderedDict()

    def wait(self, address: str, stamp: float) -> float:
        """Return how long an address still has to wait [s]."""
        guesses = self._guesses.get(address)
        return 0.0 if guesses is None else max(guesses.until - stamp, 0.0)

    def wrong(self, address: str, token: str, stamp: float) -> None:
        """Count a wrong token; the same one again is no new guess: an old page reconnects."""
        guesses = self._guesses.pop(address, None) or _Guesses(0, b"", stamp)
        if guesses.last != token.encode():
            guesses.last = token.encode()
            guesses.count += 1
            if guesses.count > FREE_GUESSES:
                doublings = min(guesses.count - FREE_GUESSES - 1, 10)
                guesses.until = stamp + min(2.0**doublings, LONGEST_WAIT)
        self._guesses[address] = guesses
        if len(self._guesses) > MOST_ADDRESSES:
            self._guesses.popitem(last=False)
