"""Whether the place is confirmed: a search since the last doubt has found no rival."""

from __future__ import annotations

from collections.abc import Sequence

from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters


class Confirmation:
    """A search confirms a place if its short map has no scan from before the last doubt.

    The place is doubted when the robot may be elsewhere, and when another place becomes the only
    likely one.
    """

    def __init__(self, given: bool = True) -> None:
        """Begin without a doubt; ``given`` says whether somebody gave the start."""
        self.standing = Standing.GIVEN if given else Standing.CONFIRMED
        """Whether the place is confirmed; as given until a doubt, or a search."""
        self._doubted_at = 0
        """Number of kept scans at the last doubt."""
        self._leader: Track | None = None
        self._search_counts = False
        self._put_off = False
        self._held = given
        """Whether the leader was confirmed before the doubt, and has not been lost since."""
        self._replacements = 0
        """How often another place became the leader since the last confirmation."""

    @property
    def confirmed(self) -> bool:
        """Whether nothing has put the place in doubt since it was given or confirmed."""
        return self.standing is not Standing.UNCONFIRMED

    def doubt(self, scans: int) -> None:
        """Doubt the place; ``scans`` is the number of kept scans so far."""
        self.standing, self._doubted_at = Standing.UNCONFIRMED, scans
        self._search_counts = self._put_off = False

    def lose(self, tracks: Sequence[Track]) -> None:
        """Forget the leader, as the place is lost: the next leader does not replace another."""
        for track in tracks:
            track.confirmed = False
        self._leader, self._held = None, False

    def follow(self, heaviest: Track, weight: float, p: HypothesisParameters) -> bool:
        """Take the heaviest track and its weight; return whether the leading place changed."""
        if weight <= ONLY_PLACE:
            return False
        before, self._leader = self._leader, heaviest
        another = before is not None and not p.alike(before.pose, heaviest.pose)
        self._held &= not another
        self._replacements += another
        return another

    def note(self, heaviest: Track, weight: float, another: bool) -> None:
        """Note on the heaviest track that it is confirmed, unless it has just become the leader."""
        heaviest.confirmed |= self.confirmed and weight > ONLY_PLACE and not another

    def is_due(self, scans: int, local: LocalMap) -> bool:
        """Whether a search of the short map that begins now would confirm the place."""
        # A shoe may look like the tape of another place; further short maps rarely see it again.
        whole = local.whole and not self._replacements
        fresh = whole or scans - self._doubted_at >= (1 + self._replacements) * len(local)
        return not (self.confirmed or self._search_counts) and local.lacking == 0 and fresh

    def begin(self, scans: int, local: LocalMap) -> None:
        """Note that a search begins."""
        self._search_counts = self.is_due(scans, local)

    def end(self, scans: int, rival: bool) -> None:
        """Note that the search is done, and whether it found a rival that fits as well.

        A rival puts off the confirmation of a new place until scans distinguish the two. It puts
        off a place that was held before only once, because a rival that looks as good over a short
        map, but not over the scans before it, is found again and again.
        """
        if self._search_counts:
            if not rival or (self._put_off and self._held):
                self.standing = Standing.CONFIRMED
            self._put_off = not self.confirmed
            if self.confirmed:
                self._held, self._replacements = True, 0
            self._doubted_at = scans if self._put_off else self._doubted_at
        elif self.standing is Standing.GIVEN and not rival:
            self.standing = Standing.CONFIRMED
        self._search_counts = False
