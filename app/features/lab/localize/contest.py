"""Follow several places where the robot may be, until scans decide between them.

Earlier reports are judged once more after a better place was found.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.features.lab.localize.candidate import AVERAGED_UPDATES, Candidate
from app.features.lab.localize.localized import ReportedPose
from app.features.lab.localize.settings import LaserSettings
from robot.geometry import Array, Pose2
from robot.scan import Scan

FIRST_DOUBT, LAST_DOUBT = 10, 500
"""Updates before a search may begin: the first wait, and the longest. The wait doubles with each
search, until another place takes the lead."""
LASTS = 10
"""Updates of a search; then each of its remaining places is followed alone."""
MOST = 40
"""Largest number of places of a search that are followed."""
SPREAD = np.diag(np.square([0.4, 0.4, 0.15]))
"""Covariance that these places start with [m, m, rad]."""
REMEMBERED_UPDATES = 2000
"""Number of updates that are remembered."""
BACK = 60
"""New places are followed back through this many updates."""
MOST_AT_ONCE = 1.0
"""Most that one update may put one place behind another, in log-likelihood per ray."""
NEAR_M = 1.5
"""A reported pose stands if the robot, followed back, comes nearer than this."""


class Contest:
    """A leader, and other places that explain the scans about as well.

    One cloud of particles that starts all over a floor does not keep two corridors that look alike:
    it drops one of them by chance, within a few metres. So after a few updates each place gets a
    filter of its own, from which no other place can take particles. A place is dropped when another
    one explains the scans better by enough, summed over all updates that both have seen. A place
    that is found later is followed back through earlier scans. A leader is confirmed when it is
    alone after a search that was made to test it.
    """

    def __init__(self, make: Callable[[], Candidate], laser: LaserSettings) -> None:
        self._make, self._laser = make, laser
        self.leader = make()
        self.others: list[Candidate] = []
        self.moments: deque[Moment] = deque(maxlen=REMEMBERED_UPDATES)
        self.places_left = 0
        """How often another place took the lead from a confirmed one."""
        self._search: Candidate | None = None
        self._search_twice = False
        self._searched_beside: Candidate | None = None
        """The leader when the last search began."""
        self._search_interval = self._wait = FIRST_DOUBT

    @property
    def alone(self) -> bool:
        """Whether only the leader is followed and no search is running."""
        return not self.others and self._search is None

    def begin_anywhere(self) -> None:
        """Start with particles all over the free floor."""
        self.leader.start_anywhere()
        self._search = self.leader
        self._search_twice = True

    def begin_at(self, pose: Pose2, covariance: Array) -> None:
        """Start at a given pose, with covariance (3, 3) [m, m, rad]."""
        self.leader.start_at(pose, covariance)
        self.leader.confirmed = True

    def take(self, odometry: Pose2, scan: Scan, *, due: bool = False) -> bool:
        """Follow the robot to a scan; return whether the scan was used.

        Args:
            odometry: the robot in the odom frame.
            scan: what its laser saw there.
            due: whether to use the scan however little the robot has moved since the last one.
        """
        leader, search = self.leader, self._search
        if not (leader.take_too if due else leader.take)(odometry, scan):
            return False
        for other in self.others:
            other.take_too(odometry, scan)
        if search is not None and search is not leader:
            search.take_too(odometry, scan)
        assert leader.estimate is not None
        self.moments.append(Moment(odometry, scan, leader.estimate.pose, leader.latest))
        if leader is not search:
            self._weigh()
        if search is not None and search.updates >= LASTS:
            self._divide(search)
        if self.alone:
            self._confirm_or_doubt()
        return True

    def copy_of_leader(self) -> Candidate:
        """Return a new candidate at the leader's place, to follow the robot back."""
        return self._copy(self.leader)

    def _weigh(self) -> None:
        """Update how far each place is behind, and drop the places that are too far behind."""
        leader = self.leader
        for candidate in self.others:
            candidate.deficit += _worse(candidate, leader)
        best = min(each.deficit for each in (leader, *self.others))
        for candidate in (leader, *self.others):
            candidate.deficit -= best
        kept: list[Candidate] = []
        limit = self._laser.doubt_behind
        if leader.deficit <= limit:
            kept.append(leader)
        for candidate in sorted(self.others, key=lambda item: item.deficit):
            same = next((other for other in kept if candidate.same_place(other)), None)
            if same is None and candidate.deficit <= limit:
                kept.append(candidate)
            elif same is leader:
                leader.deficit = min(leader.deficit, candidate.deficit)
        if kept[0] is not leader:
            self.places_left += leader.confirmed
            self._search_interval = self._wait = FIRST_DOUBT
        self.leader, *self.others = kept

    def _divide(self, search: Candidate) -> None:
        """End a search: from now on, follow each of its places alone."""
        self._search = None
        result = [self._follow(place) for place in search.places(MOST)]
        if search is self.leader:
            self.leader = result.pop(0)
        self.others += self._replay([item for item in result if not item.same_place(self.leader)])
        if self._search_twice:
            self._search_twice = False
            self._begin_search()

    def _replay(self, candidates: list[Candidate]) -> list[Candidate]:
        """Return the candidates that explain earlier scans about as well as the leader does."""
        leader = self._copy(self.leader)
        back = [(candidate, self._copy(candidate)) for candidate in candidates]
        for moment in list(self.moments)[-2 : -BACK - 1 : -1]:
            if not back:
                break
            leader.take_too(moment.odometry, moment.scan)
            for candidate, past in back:
                past.take_too(moment.odometry, moment.scan)
                candidate.deficit += _worse(past, leader)
            back = [(item, past) for item, past in back if item.deficit <= self._laser.doubt_behind]
        return [each for each, _ in back]

    def _copy(self, candidate: Candidate) -> Candidate:
        assert candidate.estimate is not None
        return self._follow(candidate.estimate.pose)

    def _follow(self, place: Pose2) -> Candidate:
        """Return a new candidate at a place of the latest moment."""
        current, item = self.moments[-1], self._make()
        item.start_at(place, SPREAD, current.odometry)
        item.take(current.odometry, current.scan)
        return item

    def _begin_search(self) -> None:
        self._searched_beside = self.leader
        self._search = self._make()
        self._search.start_anywhere()

    def _confirm_or_doubt(self) -> None:
        """Confirm a leader that is alone, or begin a search."""
        leader = self.leader
        if leader.stands and not leader.confirmed:
            if self._searched_beside is leader:
                leader.confirmed = True
            else:
                self._begin_search()
            return
        self._wait -= 1
        if self._wait <= 0 and leader.fit < self._laser.doubt_below:
            self._search_interval = min(2 * self._search_interval, LAST_DOUBT)
            self._wait = self._search_interval
            self._begin_search()


def _worse(candidate: Candidate, other: Candidate) -> float:
    """Return by how much one candidate explains its last scan worse than another, limited."""
    return min(max(other.latest - candidate.latest, -MOST_AT_ONCE), MOST_AT_ONCE)


@dataclass(frozen=True, slots=True)
class Moment:
    """An update, and the leader's result at that time."""

    odometry: Pose2
    scan: Scan
    place: Pose2
    """The leader's pose, in the frame of the map's cells."""
    latest: float
    """The leader's log-likelihood per ray."""


def withdraw(
    tolds: Iterable[ReportedPose], moments: Sequence[Moment], back: Candidate, margin: float
) -> None:
    """Mark the reported poses that hindsight does not support.

    The robot is followed back from its current place, through the remembered scans. A pose stands
    if the way back comes to the same place. It also stands if the way back explains the scans
    around it worse than the pose did: then the report was right, and the robot was carried off
    later. Poses older than the memory are judged like the oldest remembered one.

    Args:
        tolds: the reported poses, which are marked.
        moments: the remembered updates, in order of time.
        back: a candidate at the current place.
        margin: by how much a pose has to explain the scans better, in log-likelihood per ray.
    """
    near, better = [], []
    for moment in reversed(moments):
        back.take_too(moment.odometry, moment.scan)
        assert back.estimate is not None
        near.append(back.estimate.pose.distance_to(moment.place) < NEAR_M)
        better.append(moment.latest - back.latest)
    around = np.ones(min(AVERAGED_UPDATES, len(better)))
    mean = np.convolve(better, around, "same") / np.convolve(np.ones(len(better)), around, "same")
    stands = (np.array(near) | (mean > margin))[::-1]
    stamps = np.array([moment.scan.stamp for moment in moments])
    for item in tolds:
        position = max(int(np.searchsorted(stamps, item.stamp, side="right")) - 1, 0)
        item.withdrawn |= not stands[position]
