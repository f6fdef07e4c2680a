"""Whether the place is confirmed: a search since the last doubt has found no rival."""

from __future__ import annotations

from collections.abc import Sequence

from robot.geometry import Pose2
from robot.localization.estimate import ONLY_PLACE, Standing
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters

NEAR, NEAR_TURN = 0.08, 0.3
"""Odometry errs by less than this from one search to the next [m], [rad]. Half and twice: no
claim of 36 robots changes (as ``candidate_weights.OPEN``)."""


class Confirmation:
    """A search confirms a place if its short map has no scan from before the last doubt.

    The place is doubted when the robot may be elsewhere, and when another place becomes the only
    likely one. What one search since the doubt has refuted, the next one need not refute again: at
    one end of a wall a short map fits one rival, at the other end another.
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
        self._open: list[Pose2] | None = None
        """Where the robot may be as well, by all searches since the doubt; None is anywhere."""
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
        self._open = None

    def lose(self, tracks: Sequence[Track]) -> None:
        """Forget the leader, as the place is lost: the next leader does not replace another."""
        for track in tracks:
            track.confirmed = False
        self._leader, self._held, self._open = None, False, None

    def follow(self, heaviest: Track, weight: float, p: HypothesisParameters) -> bool:
        """Take the heaviest track and its weight; return whether the leading place changed."""
        if weight <= ONLY_PLACE:
            return False
        before, self._leader = self._leader, heaviest
        another = before is not None and not p.alike(before.pose, heaviest.pose)
        self._held &= not another
        self._replacements += another
        self._open = None if another else self._open
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

    def move(self, moved: Pose2) -> None:
        """Move the places that are open by a step of odometry."""
        self._open = self._open and [pose @ moved for pose in self._open]

    def end(self, scans: int, rivals: Sequence[Pose2], left: Sequence[Pose2] | None) -> None:
        """Note that the search is done, and which rivals it found that fit as well.

        A rival puts off the confirmation of a new place until scans distinguish the two, in this
        search or in another since the doubt. It puts off a place that was held before only once,
        because a rival that looks as good over a short map, but not over the scans before it, is
        found again and again.

        Args:
            scans: number of kept scans so far.
            rivals: poses that fit as well as the place.
            left: all poses that the search does not refute; None if it may have missed some.
        """
        counts, self._search_counts = self._search_counts, False
        doubted = self.standing is Standing.UNCONFIRMED
        if self.standing is Standing.CONFIRMED or (doubted and self._open is None and not counts):
            return  # The short map may go back to before the doubt.
        rival = any(map(self._is_open, rivals))
        if left is not None:
            self._open = [pose for pose in left if self._is_open(pose)]
        if not rival or (counts and self._put_off and self._held):
            self.standing = Standing.CONFIRMED
            self._held, self._replacements, self._put_off = True, 0, False
            self._open = None
        elif counts:
            self._put_off, self._doubted_at = True, scans

    def _is_open(self, pose: Pose2) -> bool:
        return self._open is None or any(
            pose.distance_to(other) < NEAR and abs(pose.turn_to(other)) < NEAR_TURN
            for other in self._open
        )
