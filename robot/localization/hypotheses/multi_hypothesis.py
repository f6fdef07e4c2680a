"""Multi-hypothesis tracking (Probabilistic Robotics, section 7.5).

Each hypothesis has its own filter. It starts where a short map of the last scans fits the field,
and is weighed by how well the rays of each scan fit. Hypotheses are never resampled against each
other: one that looks unlikely now may prove right at the next mark. Only hopeless ones are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from robot import ray_columns as column
from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud, Setup
from robot.localization.hypotheses.candidate_weights import (
    EQUAL,
    OPEN,
    missing_images,
    rival_poses,
    weigh_places,
)
from robot.localization.hypotheses.confirmation import Confirmation
from robot.localization.hypotheses.kidnapping import FRESH, Kidnapping
from robot.localization.hypotheses.place_search import PlaceSearch
from robot.localization.hypotheses.searches import Searches
from robot.localization.hypotheses.start_poses import (
    Prior,
    StartPose,
    find_start_clusters,
    start_tracks,
)
from robot.localization.hypotheses.track import Track, TrackFilter, distinct, joint_hypotheses
from robot.localization.particles.particle_filter import ParticleFilter
from robot.localization.particles.resampling import effective_sample_size, joined_sample_size
from robot.scan import Scan, rays_of

BEAMS = 60
"""Rays of a scan by which hypotheses are weighed."""
CONFIRMING = 0.5
"""A search that confirms a known place needs only this share of the returns of other searches.
Half: no claim changes; twice: certain in 41.6 % instead of 40.7, and misleading as often
(``--few``)."""
LEAST_SHARE = 0.2
"""A track keeps at least this share of its particles, however many tracks there are."""
BORN_SHARE = 0.05
"""Share of the particles of a new track: its place is known to centimetres, so a few are enough.
Half: nothing changes beyond chance; twice: one of ten places is not found (``--few``)."""
PRIOR_MAP_LENGTHS = 4
"""Lengths of a short map after which the given start does not count: scans tell more by then."""


@dataclass(frozen=True, slots=True)
class ParticleTracks:
    """Factory of particle filters that share one random generator.

    It is a class and not a closure, so that a checkpoint can save and restore it with a filter.
    """

    rng: np.random.Generator

    def __call__(self, setup: Setup, share: float) -> ParticleFilter:
        """Return a filter with a share of the usual number of particles."""
        return ParticleFilter.of(setup, self.rng, share)


class MultiHypothesisFilter:
    """Follows all places where the robot may be, and searches for others all the time.

    The weights of its hypotheses sum to less than one. The rest is the probability that the robot
    is elsewhere; it grows while no hypothesis fits.
    """

    def __init__(
        self,
        setup: Setup,
        new_filter: Callable[[Setup, float], TrackFilter],
        rng: np.random.Generator,
    ) -> None:
        """Begin at the field's start; ``new_filter`` makes a filter with a share of particles."""
        self.setup = setup
        self._new_filter = new_filter
        self._rng = rng
        self._tracks: list[Track] = []
        self._priors: list[Prior] = []
        """The given start; empty after ``scatter``, and when the start is long ago."""
        self._anywhere: Cloud
        """Displayed until a place is found."""
        self._searches: Searches
        self._joined: Cloud | None = None
        """The joined cloud of all tracks; None where it has changed. Whoever shows the robot asks
        for it 50 times a second, and it changes with each picture only."""
        self._scans = 0
        """Number of scans kept since the start."""
        self._lost_at = 0  # ``_scans`` when the place was last lost; 0 is the start.
        self._start_is_given = True
        """Whether the start was given, and the place was neither lost nor changed since."""
        self._looseness = 1.0
        self.set_pose(setup.field.start, setup.parameters.filter.initial_covariance)

    @classmethod
    def of(cls, setup: Setup, rng: np.random.Generator) -> MultiHypothesisFilter:
        """Return a filter whose places are followed by particle filters."""
        return cls(setup, ParticleTracks(rng), rng)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The hypotheses of all tracks, heaviest first; empty until a place is found."""
        return joint_hypotheses(self._tracks, self._weights())

    @property
    def cloud(self) -> Cloud:
        """The particles of all tracks; poses all over the field until a place is found."""
        if not self._tracks:
            return self._anywhere
        if self._joined is None:
            clouds = [track.filter.cloud for track in self._tracks]
            self._joined = Cloud.joined(clouds, self._weights())
        return self._joined

    @property
    def effective(self) -> float:
        """Effective sample size of the cloud."""
        if not self._tracks:
            return effective_sample_size(self._anywhere.weights)
        return joined_sample_size([t.filter.effective for t in self._tracks], self._weights())

    @property
    def standing(self) -> Standing:
        """Lost while elsewhere is likelier; unconfirmed from a doubt until a search settles it."""
        if self._elsewhere.lost:
            return Standing.LOST
        return self._confirmation.standing

    @property
    def extra_sd(self) -> float:
        """How much less the heaviest track believed the last ranges, as its particles lie apart."""
        return self._tracks[0].filter.extra_sd if self._tracks else 0.0

    def loosen(self, factor: float) -> None:
        """Multiply the motion model's standard deviations by ``factor`` from now on."""
        self._looseness = factor
        for track in self._tracks:
            track.filter.loosen(factor)

    def search_anew(self) -> None:
        """Search for the place anew: the robot was probably carried off while it stood."""
        for track in self._tracks:
            track.born = self._scans
        self._confirmation.lose(self._tracks)
        self._confirmation.doubt(self._scans)
        self._elsewhere.at_least(FRESH)
        self._joined = None
        self._restart_search(0)

    def use(self, setup: Setup) -> None:
        """Switch to other models and parameters, and keep all hypotheses."""
        if setup.hypotheses != self.setup.hypotheses:
            self._searches.use(setup.hypotheses)
        self.setup = setup
        for track in self._tracks:
            track.filter.use(setup)

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Restart with one hypothesis around a pose, with covariance (3, 3) [m, m, rad]."""
        item = self._new_filter(self.setup, 1.0)
        item.set_pose(pose, covariance)
        self._start([Track(item, 0.0)], [Prior(pose, covariance)])

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Restart at the heaviest hypotheses; only the ratios of their weights count."""
        best = sorted((h for h in hypotheses if h.weight > 0), key=lambda h: -h.weight)
        places = [StartPose(item) for item in best[: self.setup.hypotheses.max_hypotheses]]
        self._start(*start_tracks(places, self._new_filter, self.setup))

    def set_cloud(self, cloud: Cloud) -> None:
        """Restart with a hypothesis for each cluster of weighted poses.

        Poses spread over the field form no clusters: search the field instead.
        """
        places = find_start_clusters(cloud, self.setup)
        if places:
            self._start(*start_tracks(places, self._new_filter, self.setup))
        else:
            self.scatter()

    def scatter(self) -> None:
        """Restart without a hypothesis, and search the field for places."""
        count = self.setup.parameters.filter.most_particles
        self._anywhere = Cloud.even(self.setup.field.free_poses(self._rng, count))
        self._start([], [])

    def predict(self, moved: Pose2) -> None:
        """Move all hypotheses by a step of odometry."""
        self._joined = None
        for track in self._tracks:
            track.filter.predict(moved)
        self._searches.move(moved)
        self._confirmation.move(moved)
        self._priors = [prior.moved(moved, self.setup.motion) for prior in self._priors]

    def correct(self, scan: Scan) -> None:
        """Correct each hypothesis by a scan, weigh them, and search for more."""
        self._joined = None
        for track in self._tracks:
            track.filter.correct(scan)
        if self._searches.add(scan):
            self._scans += 1
            if self._scans >= PRIOR_MAP_LENGTHS * self.setup.hypotheses.map_scans:
                self._priors = []
            self._weigh(rays_of(scan, BEAMS))
            self._select()
            self._follow_images()
        self._look_around()

    def _weigh(self, rays: Array) -> None:
        """Multiply each weight by the scan's likelihood, to the power of ``scan_worth``."""
        rays = rays[~np.isnan(rays[:, column.NEAR])]
        if not self._tracks or not len(rays):
            return
        p, evidence = self.setup.hypotheses, self.setup.evidence
        fits = np.array([track.fit(rays, self.setup) for track in self._tracks])
        for track, loss in zip(self._tracks, p.scan_worth * (fits.max() - fits), strict=True):
            track.lose(float(loss), p.most_a_scan)
        best = self._tracks[int(fits.argmax())]
        self._elsewhere.weigh(best.unmatched_fit(rays, self.setup), rays, evidence, p)
        for track in self._tracks:
            if track.restart_if_stuck():
                track.born = self._scans

    def _select(self) -> None:
        """Drop hopeless tracks, and the lighter of two tracks at one place.

        The lighter one's weight is not added: it is the same place, found or followed twice.
        """
        self._tracks = distinct(self._tracks, self.setup.hypotheses)
        if self._tracks:
            self._level(self._tracks[0].log_weight)

    def _follow_images(self) -> None:
        """Follow the images of the heaviest places, unless the start was given."""
        if self._start_is_given:
            return
        p = self.setup.hypotheses
        for image in list(missing_images(self._tracks, self.setup.field.symmetries, p)):
            if len(self._tracks) < p.max_hypotheses:
                self._follow(*image)

    def _level(self, heaviest: float) -> None:
        """Scale the heaviest weight to one; react if the robot is lost or another place leads."""
        for track in self._tracks:
            track.log_weight -= heaviest
        lost_now = self._elsewhere.level(heaviest, self.setup.hypotheses)
        weights = self._weights().tolist()
        for track, weight in zip(self._tracks, weights, strict=True):
            track.filter.share = max(weight, LEAST_SHARE)
        another = self._confirmation.follow(self._tracks[0], weights[0], self.setup.hypotheses)
        if not self._priors:  # A given start is not confirmed by being given.
            self._confirmation.note(self._tracks[0], weights[0], another)
        if self._elsewhere.suspected or another:
            self._confirmation.doubt(self._scans)
        if lost_now:
            self._confirmation.lose(self._tracks)
            self._restart_search(max(self._elsewhere.doubts, 1))
        elif another:
            self._restart_search(max(self._scans - self._tracks[0].born, 1))

    def _restart_search(self, scans: int) -> None:
        """Forget all but about the last ``scans`` scans: before them the robot was carried off."""
        self._searches.restart(scans)
        self._priors, self._lost_at = [], self._scans
        self._start_is_given = False

    def _look_around(self) -> None:
        """Begin a search for places, or do the next piece of it."""
        if self._is_search_due():
            self._confirmation.begin(self._scans, self._searches.local)
            self._searches.begin(self._tracks[0].pose if self._tracks else None, self.setup)
        elif (done := self._searches.advance()) is not None:
            self._add_places(done)

    def _is_search_due(self) -> bool:
        local, least = self._searches.local, self.setup.hypotheses.least_hits
        if self._confirmation.is_due(self._scans, local):
            return local.hit_share >= CONFIRMING * least
        return self._searches.is_due and local.hit_share >= least

    def _add_places(self, search: PlaceSearch) -> None:
        """Follow the places that a search has found."""
        p = self.setup.hypotheses
        # What confirmed the place is no longer in the short map, which a row of places may fit.
        if self._confirmation.standing is Standing.CONFIRMED and not search.whole:
            self._priors = []
        # If the short map goes back to where the robot was lost or scattered, a place found now is
        # as likely as an earlier one that fits as well. But if the leading track is older than the
        # loss, and fits again, its place was not lost at all.
        old = any(track.born < self._lost_at for track in self._tracks[:1])
        whole = search.whole and not self._priors and not old
        lost = self._elsewhere.log_weight
        places = weigh_places(search, self._tracks, self._priors, lost, whole, p)
        known = search, self._tracks, places, self.setup.field.symmetries, p
        rivals, left = rival_poses(*known, EQUAL), rival_poses(*known, OPEN)
        # If most of what was found is open, more may be; anything may, on floor that nobody saw.
        complete = len(search.found) < p.max_hypotheses or 2 * len(left) < p.max_hypotheses
        complete &= not any(each.unseen.any() for each in search.found)
        self._confirmation.end(self._scans, rivals, left if complete else None)
        before = len(self._tracks)
        for place in places:
            if place.log_weight > p.log_hopeless:
                self._follow(place.pose, place.covariance, place.log_weight)
        # A new place that is not hopeless may be the first of several.
        more = len(self._tracks) > before
        unconfirmed = self._confirmation.standing is Standing.GIVEN
        self._searches.end(has_places=bool(places), more=more or unconfirmed)
        if places:
            self._select()
        if whole and more:  # A better fit than a bad one is not certain yet.
            self._elsewhere.at_least(FRESH)

    def _follow(self, pose: Pose2, covariance: Array, log_weight: float) -> None:
        born = self._new_filter(self.setup, BORN_SHARE)
        born.set_pose(pose, covariance)
        born.loosen(self._looseness)
        self._tracks.append(Track(born, log_weight, self._scans))

    def _start(self, tracks: list[Track], priors: list[Prior]) -> None:
        p = self.setup.hypotheses
        self._tracks, self._joined = tracks, None
        self._priors = priors
        self._elsewhere = Kidnapping(p.log_kidnapped if tracks else FRESH)
        self._scans = self._lost_at = 0
        self._confirmation, self._start_is_given = Confirmation(bool(priors)), bool(priors)
        self._searches = Searches(p)

    def _weights(self) -> Array:
        return self._elsewhere.beside([track.log_weight for track in self._tracks])
