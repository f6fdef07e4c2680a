"""Has the whole field been searched since the place was doubted last?"""

from __future__ import annotations

from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.track import Track
from robot.localization.hypothesis_parameters import HypothesisParameters

LEADING = 0.95
"""A place that weighs more is the only likely one."""


class Confirmation:
    """A place is confirmed by a search of a short map that knows of no scan of before the doubt.

    It is doubted when it may be elsewhere, and when another place has become the only likely one.
    """

    def __init__(self, held: bool = True) -> None:
        """``held``: whether the place was told."""
        self.is_given = True
        """Also of a place that was told, until it is doubted."""
        self._doubted_at = 0
        """Scans kept then."""
        self._leader: Track | None = None
        self._search_counts = False
        self._put_off = False
        self._held = held
        """Whether the leader was confirmed before the doubt, and has not been lost since."""

    def doubt(self, scans: int) -> None:
        """It may be elsewhere; so many scans were kept so far."""
        self.is_given, self._doubted_at = False, scans
        self._search_counts = self._put_off = False

    def lose(self) -> None:
        """The place is lost: whichever leads next follows no other."""
        self._leader, self._held = None, False

    def follow(self, heaviest: Track, weight: float, p: HypothesisParameters) -> bool:
        """Take the heaviest track with its share; whether it leads at another place than before."""
        if weight <= LEADING:
            return False
        before, self._leader = self._leader, heaviest
        another = before is not None and not p.alike(before.pose, heaviest.pose)
        self._held &= not another
        return another

    def is_due(self, scans: int, local: LocalMap) -> bool:
        """Whether a search of the short map that begins now would confirm the place."""
        fresh = local.whole or scans - self._doubted_at >= len(local)
        return not (self.is_given or self._search_counts) and local.lacking == 0 and fresh

    def begin(self, scans: int, local: LocalMap) -> None:
        """A search begins."""
        self._search_counts = self.is_due(scans, local)

    def end(self, scans: int, rival: bool) -> None:
        """It is done, and has found a rival that fits as well, or none.

        A rival puts off a place that is new until scans tell them apart. It puts off a place that
        was held before only once: what looks as good over a short map, but not over the scans
        before, is found again and again.
        """
        if self._search_counts:
            self.is_given = not rival or (self._put_off and self._held)
            self._put_off = not self.is_given
            self._held |= self.is_given
            self._doubted_at = scans if self._put_off else self._doubted_at
        self._search_counts = False
