"""Several hypotheses that live: multi-hypothesis tracking (Probabilistic Robotics, section 7.5).

Each is a filter of its own. They are born where a short map of the last scans fits the field,
weighed by how well the rays of each scan fit, and never resampled against each other: what looks
unlikely now may be right when a mark comes into sight. Only a hopeless one is given up.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud
from robot.localization.hypotheses.candidate_weights import equal_tracks, found_places, has_rival
from robot.localization.hypotheses.confirmation import Confirmation
from robot.localization.hypotheses.images import missing_images
from robot.localization.hypotheses.kidnapping import FRESH, Kidnapping
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.prior import Prior
from robot.localization.hypotheses.start_poses import StartPose, begun_at, clusters_of
from robot.localization.hypotheses.track import Track, TrackFilter, distinct
from robot.localization.particles.resampling import effective_sample_size, joined_sample_size
from robot.localization.rays import rays_of
from robot.localization.setup import Setup
from robot.scan import Scan

BEAMS = 60
"""Rays of a scan by which hypotheses are weighed."""
FIRST, LOST, SOON, LATE = 12, 2, 8, 64
"""Scans before the first search, and when lost; between searches that find something, and at most,
when they find nothing."""
CONFIRMING = 0.5
"""To confirm a place that is known, so much of the returns do that a search else needs."""
LEAST_SHARE = 0.2
"""A track keeps at least this part of its particles, however many there are."""
BORN_SHARE = 0.05
"""A place is found within centimetres: a few particles do to begin with."""
REMEMBERED = 4
"""Short maps' lengths for which it counts what was told of the start: then more has been seen."""


class MultiHypothesisFilter:
    """Follows all places where the robot may be, and looks for others all the time.

    The weights of its hypotheses sum to less than one: what is missing is the probability that the
    robot is elsewhere. It grows while no hypothesis fits.
    """

    def __init__(
        self,
        setup: Setup,
        new_filter: Callable[[Setup, float], TrackFilter],
        rng: np.random.Generator,
    ) -> None:
        """At the field's start; ``new_filter`` makes one that keeps a share of the particles."""
        self.setup = setup
        self._new_filter = new_filter
        self._rng = rng
        self._tracks: list[Track] = []
        self._told: list[Prior] = []
        """What was said of the start; nothing after ``scatter``, nor when that is long ago."""
        self._anywhere: Cloud
        """Shown while nothing was found yet."""
        self._local: LocalMap
        self._search: PlaceSearch | None = None
        self._scans = 0
        """Kept since the start."""
        self._lost_at = 0  # The same, when it was last lost or the start.
        self._anchored = True
        """Whether the start was told, and it was never lost since."""
        self._confirmation = Confirmation()
        self._looseness = 1.0
        self._wait = FIRST
        """Scans until the next search."""
        self._patience = SOON
        """Scans between searches, at present."""
        self._elsewhere = Kidnapping(FRESH)
        self.set_pose(setup.field.start, setup.parameters.filter.initial_covariance)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All of all tracks, heaviest first; none while nothing was found yet."""
        result = [
            Hypothesis(item.weight * weight, item.pose, item.covariance)
            for track, weight in zip(self._tracks, self._weights().tolist(), strict=True)
            for item in track.hypotheses
        ]
        return tuple(sorted(result, key=lambda item: -item.weight))

    @property
    def cloud(self) -> Cloud:
        """The particles of all tracks; poses all over the field while nothing was found yet."""
        if not self._tracks:
            return self._anywhere
        return Cloud.joined([track.filter.cloud for track in self._tracks], self._weights())

    @property
    def effective(self) -> float:
        """Effective sample size of the cloud."""
        if not self._tracks:
            return effective_sample_size(self._anywhere.weights)
        return joined_sample_size([t.filter.effective for t in self._tracks], self._weights())

    @property
    def standing(self) -> Standing:
        """Lost while elsewhere is likelier; then confirmed by a search of a whole short map."""
        if self._elsewhere.lost:
            return Standing.LOST
        return Standing.CONFIRMED if self._confirmation.is_given else Standing.UNCONFIRMED

    def loosen(self, factor: float) -> None:
        """Let steps err so many times more than the motion model says."""
        self._looseness = factor
        for track in self._tracks:
            track.filter.loosen(factor)

    def use(self, setup: Setup) -> None:
        """Go on with other models and parameters; all hypotheses stay."""
        if setup.hypotheses != self.setup.hypotheses:
            self._local, self._search, self._wait = LocalMap.of(setup.hypotheses), None, FIRST
            self._local.whole = False
        self.setup = setup
        for track in self._tracks:
            track.filter.use(setup)

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Start anew with one hypothesis around a pose, with covariance (3, 3) [m, m, rad]."""
        item = self._new_filter(self.setup, 1.0)
        item.set_pose(pose, covariance)
        self._start([Track(item, 0.0)], [Prior(pose, covariance)])

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Start anew at the likeliest of some places; their weights are relative to each other."""
        best = sorted((h for h in hypotheses if h.weight > 0), key=lambda h: -h.weight)
        places = [StartPose(item) for item in best[: self.setup.hypotheses.max_hypotheses]]
        self._start(*begun_at(places, self._new_filter, self.setup))

    def set_cloud(self, cloud: Cloud) -> None:
        """Start anew with a hypothesis for each cluster of given weighted poses.

        Poses that are all over the field are no places: then it is looked for them.
        """
        places = clusters_of(cloud, self.setup)
        if places:
            self._start(*begun_at(places, self._new_filter, self.setup))
        else:
            self.scatter()

    def scatter(self) -> None:
        """Start anew without any: places are looked for."""
        count = self.setup.parameters.filter.most_particles
        self._anywhere = Cloud.even(self.setup.field.free_poses(self._rng, count))
        self._start([], [])

    def predict(self, moved: Pose2) -> None:
        """Follow a step by odometry."""
        for track in self._tracks:
            track.filter.predict(moved)
        self._local.move(moved)
        if self._search is not None:
            self._search.move(moved)
        self._told = [prior.moved(moved, self.setup.motion) for prior in self._told]

    def correct(self, scan: Scan) -> None:
        """Correct each hypothesis by a scan, weigh them, and look for more."""
        for track in self._tracks:
            track.filter.correct(scan)
        if self._local.add(scan):
            self._wait -= 1
            self._scans += 1
            if self._scans >= REMEMBERED * self.setup.hypotheses.map_scans:
                self._told = []
            self._weigh(rays_of(scan, BEAMS))
            self._select()
            self._mirror()
        self._look_around()

    def _weigh(self, rays: Array) -> None:
        """Multiply each weight by the scan's likelihood, to the power that a scan is worth."""
        rays = rays[~np.isnan(rays[:, 4])]
        if not self._tracks or not len(rays):
            return
        p, evidence = self.setup.hypotheses, self.setup.evidence
        fits = np.array([track.fit(rays, self.setup) for track in self._tracks])
        for track, loss in zip(self._tracks, p.scan_worth * (fits.max() - fits), strict=True):
            track.lose(float(loss), p.most_a_scan)
        best = self._tracks[int(fits.argmax())]
        self._elsewhere.weigh(best.fit_unlaid(rays, self.setup), rays, evidence, p)
        for track in self._tracks:
            if track.come_unstuck():
                track.born = self._scans

    def _select(self) -> None:
        """Give up what is hopeless, and the lighter of two that are in one place.

        The lighter one's weight is not added: it is the same place, found or followed twice.
        """
        self._tracks = distinct(self._tracks, self.setup.hypotheses)
        if self._tracks:
            self._level(self._tracks[0].log_weight)

    def _mirror(self) -> None:
        """Follow what looks the same as the heaviest places, unless the start was told."""
        if self._anchored:
            return
        p = self.setup.hypotheses
        for image in list(missing_images(self._tracks, self.setup.field.symmetries, p)):
            if len(self._tracks) < p.max_hypotheses:
                self._follow(image.pose, image.covariance, image.log_weight)

    def _level(self, heaviest: float) -> None:
        """Make the heaviest weight one; notice when elsewhere has become the likeliest."""
        for track in self._tracks:
            track.log_weight -= heaviest
        lost_now = self._elsewhere.level(heaviest, self.setup.hypotheses)
        weights = self._weights().tolist()
        for track, weight in zip(self._tracks, weights, strict=True):
            track.filter.share = max(weight, LEAST_SHARE)
        another = self._confirmation.follow(self._tracks[0], weights[0], self.setup.hypotheses)
        if self._elsewhere.suspected or another:
            self._confirmation.doubt(self._scans)
        if lost_now:
            self._confirmation.lose()
            self._begin_anew(self._elsewhere.doubts)
        elif another:
            self._begin_anew(self._scans - self._tracks[0].born)

    def _begin_anew(self, scans: int) -> None:
        """Forget what was before the robot was carried, about so many scans ago."""
        self._local.begin_anew(max(scans, 1))
        self._search, self._wait = None, LOST
        self._told, self._lost_at = [], self._scans
        self._anchored = False

    def _look_around(self) -> None:
        """Begin a search for places, or go on with it."""
        if self._is_search_due():
            self._confirmation.begin(self._scans, self._local)
            back = self._local.since.inverse()
            alive = [track.pose @ back for track in self._tracks[:1]]
            self._search = PlaceSearch(self._local, alive, self.setup)
            self._wait = self._patience
        elif self._search is not None and self._search.advance():
            self._bear(self._search)
            self._search = None

    def _is_search_due(self) -> bool:
        least = self.setup.hypotheses.least_hits
        if self._confirmation.is_due(self._scans, self._local):
            return self._local.hit_share >= CONFIRMING * least
        return self._search is None and self._wait <= 0 and self._local.hit_share >= least

    def _bear(self, search: PlaceSearch) -> None:
        """Follow the places that were found."""
        p = self.setup.hypotheses
        # Back to where it was lost, or to a start of which nothing was told, a place found now is
        # as likely as one that was found since then, or come to, and fits as well. But a place that
        # was held before and fits again was not lost at all.
        old = any(track.born < self._lost_at for track in self._tracks[:1])
        whole = search.whole and not self._told and not old
        elsewhere = self._elsewhere.log_weight
        places = found_places(search, self._tracks, self._told, elsewhere, whole, p)
        followed = equal_tracks(search, self._tracks, p)
        rival = has_rival(self._tracks, places, followed, self.setup.field.symmetries, p)
        self._confirmation.end(self._scans, rival)
        before = len(self._tracks)
        for place in places:
            if place.log_weight > p.log_hopeless:
                self._follow(place.pose, place.covariance, place.log_weight)
        # A place that is new, and not hopeless, may be the first of more.
        result = len(self._tracks) > before
        self._patience = SOON if result else min(2 * self._patience, LATE)
        if places:
            self._wait = min(self._wait, self._patience)
            self._select()
        if whole and result:  # To fit better than what fitted badly is no certainty.
            self._elsewhere.at_least(FRESH)

    def _follow(self, pose: Pose2, covariance: Array, log_weight: float) -> None:
        born = self._new_filter(self.setup, BORN_SHARE)
        born.set_pose(pose, covariance)
        born.loosen(self._looseness)
        self._tracks.append(Track(born, log_weight, self._scans))

    def _start(self, tracks: list[Track], priors: list[Prior]) -> None:
        p = self.setup.hypotheses
        self._tracks = tracks
        self._told = priors
        self._elsewhere = Kidnapping(p.log_kidnapped if tracks else FRESH)
        self._scans = self._lost_at = 0
        self._search, self._wait, self._patience = None, FIRST, SOON
        self._confirmation, self._anchored = Confirmation(bool(priors)), bool(priors)
        self._local = LocalMap.of(p)

    def _weights(self) -> Array:
        return self._elsewhere.beside([track.log_weight for track in self._tracks])
