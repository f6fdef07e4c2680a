"""The probability that the robot is at none of the followed places."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot.geometry import Array
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters
from robot.localization.ray_evidence import RayEvidence

FRESH = -2.5
"""Log-weight of being elsewhere when places are found for the first time."""

SUSPECTED = 2 / 3
"""A kidnapping is suspected if its log-weight rises above this share of ``log_kidnapped``."""


class Kidnapping:
    """Log-weight of being elsewhere; it grows while no hypothesis fits.

    It does not fall below the probability that the robot was carried off just now.
    """

    def __init__(self, log_weight: float) -> None:
        self.log_weight = log_weight
        """Relative to the heaviest hypothesis."""
        self.lost = False
        """Whether elsewhere is likelier than the heaviest hypothesis."""
        self.suspected = False
        """Whether elsewhere is likelier than usual."""
        self.doubts = 0
        """Number of successive scans that fit no place."""

    def weigh(
        self, best: float, rays: Array, evidence: RayEvidence, p: HypothesisParameters
    ) -> None:
        """Compare how well rays (n, 9) fit the best hypothesis with a place that fits badly."""
        anywhere = evidence.background_log_likelihood(rays)
        gain = p.scan_worth * (anywhere - best)
        self.log_weight += min(max(gain, -p.most_a_scan), 1.5 * p.most_a_scan)
        self.doubts = self.doubts + 1 if gain > 0 else 0

    def level(self, heaviest: float, p: HypothesisParameters) -> bool:
        """Scale the heaviest weight to one; return whether the robot has just become lost."""
        least, before = p.log_kidnapped, self.lost
        self.suspected = self.log_weight - heaviest > SUSPECTED * least
        self.log_weight = min(max(self.log_weight - heaviest, least), -least)
        self.lost = self.log_weight > 0
        return self.lost and not before

    def beside(self, log_weights: list[float]) -> Array:
        """Return the weights (n,) of places; with that of being elsewhere, they sum to one."""
        likelihood = np.exp(log_weights)
        weights: Array = likelihood / (likelihood.sum() + math.exp(self.log_weight))
        return weights

    def at_least(self, log_weight: float) -> None:
        """Raise the log-weight to at least this value."""
        self.log_weight = max(self.log_weight, log_weight)


LEADING = 0.95
"""Weight above which a place is the only likely one."""


class Confirmation:
    """A search confirms a place if its short map has no scan from before the last doubt.

    The place is doubted when the robot may be elsewhere, and when another place becomes the only
    likely one.
    """

    def __init__(self, held: bool = True) -> None:
        """Begin without a doubt; ``held`` says whether the start was given."""
        self.is_given = True
        """Whether the place is confirmed; true from the start until a doubt."""
        self._doubted_at = 0
        """Number of kept scans at the last doubt."""
        self._leader: Track | None = None
        self._search_counts = False
        self._put_off = False
        self._held = held
        """Whether the leader was confirmed before the doubt, and has not been lost since."""
        self._replacements = 0
        """How often another place became the leader since the last confirmation."""

    def doubt(self, scans: int) -> None:
        """Doubt the place; ``scans`` is the number of kept scans so far."""
        self.is_given, self._doubted_at = False, scans
        self._search_counts = self._put_off = False

    def lose(self, tracks: Sequence[Track]) -> None:
        """Forget the leader, as the place is lost: the next leader does not replace another."""
        for track in tracks:
            track.confirmed = False
        self._leader, self._held = None, False

    def follow(self, heaviest: Track, weight: float, p: HypothesisParameters) -> bool:
        """Take the heaviest track and its weight; return whether the leading place changed."""
        if weight <= LEADING:
            return False
        before, self._leader = self._leader, heaviest
        another = before is not None and not p.alike(before.pose, heaviest.pose)
        self._held &= not another
        self._replacements += another
        return another

    def note(self, heaviest: Track, weight: float, another: bool) -> None:
        """Note on the heaviest track that it is confirmed, unless it has just become the leader."""
        heaviest.confirmed |= self.is_given and weight > LEADING and not another

    def is_due(self, scans: int, local: LocalMap) -> bool:
        """Whether a search of the short map that begins now would confirm the place."""
        # A shoe may look like the tape of another place; further short maps rarely see it again.
        whole = local.whole and not self._replacements
        fresh = whole or scans - self._doubted_at >= (1 + self._replacements) * len(local)
        return not (self.is_given or self._search_counts) and local.lacking == 0 and fresh

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
            self.is_given = not rival or (self._put_off and self._held)
            self._put_off = not self.is_given
            if self.is_given:
                self._held, self._replacements = True, 0
            self._doubted_at = scans if self._put_off else self._doubted_at
        self._search_counts = False
