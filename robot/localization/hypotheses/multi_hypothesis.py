"""Several hypotheses that live: multi-hypothesis tracking (Probabilistic Robotics, section 7.5).

Each is a filter of its own. They are born where a short map of the last scans fits the field,
weighed by how well the rays of each scan fit, and never resampled against each other: what looks
unlikely now may be right when a mark comes into sight. Only a hopeless one is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud, Filter
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import Place, PlaceSearch, SearchSettings
from robot.localization.models.entry_field import EntryField
from robot.localization.models.motion_models import MotionModel
from robot.localization.rays import rays_of
from robot.localization.scan_matching import ScanMatcher
from robot.scan import Scan


POLISH = np.diag(np.square([0.005, 0.005, 0.02]))
"""How far a hypothesis is moved to where a scan fits, beyond its own covariance [m, m, rad]."""


@dataclass
class Track:
    """One hypothesis."""

    filter: Filter
    log_weight: float
    """Relative to the heaviest."""

    @property
    def best(self) -> Hypothesis:
        """Where it says the robot is."""
        return self.filter.hypotheses[0]


@dataclass(frozen=True)
class HypothesisSettings:
    search: SearchSettings
    scans_first: int = 12
    scans_lost: int = 2
    scans_sure: int = 24
    scans_later: int = 8
    scans_most: int = 24
    spacing_xy: float = 0.009
    spacing_theta: float = 0.05
    least_hits: float = 0.7
    rays_a_scan: float = 4.5
    """So many independent rays is one scan worth."""
    map_worth: float = 0.6
    most_a_scan: float = 3.0
    kidnap: float = -9.0
    seen_anywhere: float = 1.7
    missed_anywhere: float = -0.2
    hopeless: float = 12.0
    most: int = 24
    merge_xy: float = 0.03
    merge_theta: float = 0.1


class MultiHypothesisFilter:
    """Looks for places all the time, and follows all that are not hopeless."""

    def __init__(
        self,
        new_filter: Callable[[], Filter],
        entries: EntryField,
        matcher: ScanMatcher,
        field: Field,
        settings: HypothesisSettings,
        motion: MotionModel,
        covariance: Array,
    ) -> None:
        self._new_filter = new_filter
        self._entries = entries
        self._matcher = matcher
        self._field = field
        self._settings = settings
        self._motion = motion
        self._tracks: list[Track] = []
        self._told: tuple[Pose2, Array] | None = None
        self._local = self._new_map()
        self._search: PlaceSearch | None = None
        self._since_search = Pose2()
        self._wait = settings.scans_first
        self.set_pose(field.start, covariance)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        found = [
            replace(one, weight=one.weight * weight)
            for track, weight in zip(self._tracks, self._weights(), strict=True)
            for one in track.filter.hypotheses
        ]
        return tuple(sorted(found, key=lambda one: -one.weight))

    @property
    def cloud(self) -> Cloud:
        if not self._tracks:
            return self._anywhere
        clouds = [track.filter.cloud for track in self._tracks]
        w=self._weights(); weights = [c.weights * w for c, w in zip(clouds, w/w.sum(), strict=True)]
        return Cloud(np.concatenate([c.poses for c in clouds]), np.concatenate(weights))

    @property
    def effective(self) -> float:
        return float(1 / np.square(self.cloud.weights).sum())

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        one = self._new_filter()
        one.set_pose(pose, covariance)
        self._restart([Track(one, 0.0)], (pose, covariance))

    def set_cloud(self, cloud: Cloud) -> None:
        one = self._new_filter()
        one.set_cloud(cloud)
        self._restart([Track(one, 0.0)], None)

    def scatter(self) -> None:
        self._restart([], None)
        self._anywhere = Cloud.even(self._field.free_poses(np.random.default_rng(0), 2000))

    def predict(self, moved: Pose2) -> None:
        for track in self._tracks:
            track.filter.predict(moved)
        self._local.move(moved)
        self._since_search = self._since_search @ moved
        if self._told:
            self._told = self._told[0] @ moved, self._told[1]

    def correct(self, scan: Scan) -> None:
        for track in self._tracks:
            track.filter.correct(scan)
        if self._local.add(scan):
            self._wait -= 1
            self._weigh(rays_of(scan, 60))
            self._select()
        self._look_around()

    def _weigh(self, rays: Array) -> None:
        s = self._settings
        if not self._tracks:
            return
        fits = np.array([self._fit(track.best, rays) for track in self._tracks])
        gained = s.rays_a_scan * (fits - fits.max())
        # No single scan decides alone.
        for track, gain in zip(self._tracks, np.maximum(gained, -s.most_a_scan), strict=True):
            track.log_weight += float(gain)
        hits = np.isfinite(rays[:, 3]).mean()
        anywhere = s.seen_anywhere * hits + s.missed_anywhere * (1 - hits)
        as_is = self._matcher.log_likelihood(self._tracks[int(fits.argmax())].best.pose, rays)
        gain = s.rays_a_scan * (anywhere - as_is)
        self._elsewhere += float(np.clip(gain, -s.most_a_scan, 1.5 * s.most_a_scan))
        self._doubts = self._doubts + 1 if gain > 0 else 0

    def _fit(self, of: Hypothesis, rays: Array) -> float:
        """How well rays fit at a hypothesis, once it is moved to where they fit best.

        So that a filter's luck in finding its mean does not count.
        """
        information = np.linalg.inv(of.covariance + POLISH)
        pose = self._matcher.match(of.pose, rays, information).pose
        return self._matcher.log_likelihood(pose, rays)

    def _select(self) -> None:
        s = self._settings
        kept: list[Track] = []
        for track in sorted(self._tracks, key=lambda t: -t.log_weight):
            best = track.best.pose
            hopeless = kept and track.log_weight < kept[0].log_weight - s.hopeless
            if not hopeless and not any(self._alike(best, k.best.pose) for k in kept):
                kept.append(track)
        self._tracks = kept[: s.most]
        if not kept: return
        heaviest = kept[0].log_weight
        for track in self._tracks:
            track.log_weight -= heaviest
        self._elsewhere = min(max(self._elsewhere - heaviest, s.kidnap), -s.kidnap)
        lost = self._elsewhere > 0
        if lost and not self._lost:
            self._local.forget(max(self._doubts, 1))
            self._wait = s.scans_lost
            self._search = None
        self._lost = lost

    def _alike(self, a: Pose2, b: Pose2) -> bool:
        s = self._settings
        return a.distance_to(b) < s.merge_xy and abs(a.turn_to(b)) < s.merge_theta

    def _look_around(self) -> None:
        s = self._settings
        if self._search is not None:
            if self._search.advance():
                self._bear(self._search.found)
                self._search = None
        elif self._wait <= 0 and self._local.hit_share >= s.least_hits:
            self._search = PlaceSearch(
                self._local,
                self._motion,
                [t.best.pose for t in self._tracks[:1]],
                self._entries,
                self._matcher,
                s.search,
            )
            self._since_search = self._local.since
            self._wait = s.scans_sure if self._weights()[:1].sum() > .95 else s.scans_later

    def _bear(self, places: list[Place]) -> None:
        s = self._settings
        assert self._search is not None
        now = self._since_search
        worth = s.rays_a_scan * self._search.entries / len(self._search.past.moves)
        best = self._tracks[0] if self._tracks else None
        reference = (
            self._search.alive[0].fits
            if self._search.alive and best
            else max((p.life.fits for p in places), key=lambda f: f.sum())
        )
        for place in places:
            life = place.life
            pose = life.pose @ now
            if any(self._alike(pose, track.best.pose) for track in self._tracks):
                continue
            weight = worth * float(np.sum(life.fits - reference))
            if best:
                prior = self._prior(pose)
                # One of the places elsewhere is no likelier than all of them together.
                weight = best.log_weight + min(weight + prior, max(self._elsewhere, prior))
            if weight < -s.hopeless:
                continue
            born = self._new_filter()
            born.set_pose(pose, np.linalg.inv(life.information))
            self._tracks.append(Track(born, weight))
        self._select()

    def _prior(self, pose: Pose2) -> float:
        far = self._settings.kidnap
        if self._told is None:
            return far
        told, covariance = self._told
        off = np.array([pose.x - told.x, pose.y - told.y, told.turn_to(pose)])
        return float(np.logaddexp(-0.5 * off @ np.linalg.solve(covariance, off), far))

    def _restart(self, tracks: list[Track], told: tuple[Pose2, Array] | None) -> None:
        self._tracks = tracks
        self._told = told
        self._elsewhere = self._settings.kidnap if told else -3.0
        self._lost = False
        self._doubts = 0
        self._search = None
        self._local = self._new_map()
        self._wait = self._settings.scans_first

    def _new_map(self) -> LocalMap:
        s = self._settings
        return LocalMap(s.spacing_xy, s.spacing_theta, s.scans_most)

    def _weights(self) -> Array:
        if not self._tracks:
            return np.empty(0)
        likelihood = np.exp([track.log_weight for track in self._tracks])
        weights: Array = likelihood / (likelihood.sum() + math.exp(self._elsewhere))
        return weights
