"""Localizer: updates a filter, with odometry and with scans after motion."""

from __future__ import annotations

import math
from dataclasses import replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.localization.estimate import (
    BOUNDED,
    SEARCHING,
    Estimate,
    Hypothesis,
    Integrity,
    Standing,
)
from robot.localization.filter import Cloud, Filter, Setup
from robot.localization.filter_kinds import FILTERS
from robot.localization.monitoring.claims import claim, propagate_claim
from robot.localization.monitoring.doubt import NO_DOUBT
from robot.localization.monitoring.monitor import Monitor
from robot.localization.parameters import FilterParameters, LocalizationParameters
from robot.localization.refinement import Refinement
from robot.scan import Scan

if TYPE_CHECKING:
    from robot.localization.search_beside import SearchBeside

MIN_DESCRIBED_WEIGHT = 0.9
"""From this total weight on, the hypotheses alone describe a filter's belief."""


class Localizer:
    """Updates a filter by the same rules as nav2_amcl."""

    def __init__(
        self,
        belief: Filter,
        parameters: FilterParameters,
        refinement: Refinement | None = None,
        reach: tuple[float, float] = (0.0, math.inf),
        monitor: Monitor | None = None,
        beside: SearchBeside | None = None,
    ) -> None:
        self.reach = reach
        """Shortest and longest range that are trusted [m]."""
        self.filter = belief
        self.parameters = parameters
        self.refinement = refinement
        """Refines the heaviest hypothesis; None leaves it as the filter computed it."""
        self.monitor = monitor
        """Checks scans and odometry; without it, claims rest on weights and covariance alone."""
        self.beside = beside
        """Searches the field where the filter does not; None if that does, or on a laser's map."""
        self.updates = 0
        """Scans used since the last restart."""
        self.integrity: Integrity = SEARCHING
        """The claim about the newest estimate."""
        self.now: Pose2 | None = None
        """The robot's current pose in the odom frame, for restarts; None: that of the next scan."""
        self.seen: Scan | None = None
        """The newest scan as the filter takes it, whether or not it was due."""
        self._concluded: tuple[Hypothesis, ...] = ()
        """Where the robot may be by the last scan that was used; empty before the first."""
        self._was_certain = False
        """Whether the claim about it was certain."""
        self._still_fits = True
        """Whether what was seen since then, while the robot stood, fits there."""
        self._odometry: Pose2 | None = None
        self._forced = True

    @classmethod
    def of(cls, belief: Filter, setup: Setup, monitor: Monitor | None = None) -> Localizer:
        """Return a localizer with the parameters and models of a setup."""
        parameters, beside = setup.parameters.filter, search_beside(setup)
        return cls(belief, parameters, Refinement.of(setup), setup.reach, monitor, beside)

    @classmethod
    def of_field(
        cls,
        field: Field,
        parameters: LocalizationParameters = LocalizationParameters(),
        seed: int = 0,
    ) -> Localizer:
        """Return a localizer on a field, at its start pose, with the filter of the parameters."""
        setup = Setup.of_field(field, parameters)
        return cls.of(make_filter(setup, np.random.default_rng(seed)), setup)

    def use(self, setup: Setup) -> None:
        """Take the parameters and models of a setup from the next scan on."""
        self.parameters = setup.parameters.filter
        self.refinement = Refinement.of(setup)
        self.reach = setup.reach
        if self.beside is not None:
            self.beside.use(setup)

    def exchange(self, new: Filter, setup: Setup) -> None:
        """Go on with another filter, which starts from the belief of the one before."""
        # What searches the field goes on, in its place or beside it: it alone remembers what was
        # given, and what was doubted.
        old, searching = self.filter, None if self.beside is None else self.beside.filter
        searching = old if FILTERS[self.parameters.filter].has_hypotheses else searching
        self.beside = search_beside(setup, searching)
        if searching is not None and type(new) is type(searching):
            self.filter = searching
            self.filter.use(setup)
        else:
            self.filter = transfer_belief(new, old)
        self.use(setup)

    def set_pose(self, pose: Pose2, covariance: Array | None = None) -> None:
        """Restart around a pose in the map; the default covariance (3, 3) is the parameters'."""
        given = self.parameters.initial_covariance if covariance is None else covariance
        for each in self._filters:
            each.set_pose(pose, given)
        self._restart()

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Restart at hypotheses; only the ratios of their weights count."""
        for each in self._filters:
            each.set_hypotheses(hypotheses)
        self._restart()

    def set_cloud(self, cloud: Cloud) -> None:
        """Restart from weighted poses."""
        for each in self._filters:
            each.set_cloud(cloud)
        self._restart()

    def scatter(self) -> None:
        """Restart without a known place: the robot may be anywhere on the field."""
        for each in self._filters:
            each.scatter()
        self._restart()

    def force_update(self) -> None:
        """Let the next scan count, however little the robot moves."""
        self._forced = True

    @property
    def settled(self) -> bool:
        """Whether more scans tell it nothing while the robot stands."""
        if self._forced or self._is_due(Pose2()):
            return False
        return self.monitor is None or self.monitor.fits_clearly

    def predict(self, odometry: Pose2) -> bool:
        """Move the belief by odometry alone, while scans are paused.

        Args:
            odometry: the robot in the odom frame.

        Returns:
            Whether the belief moved. It stays if the robot has hardly moved since the last time.
        """
        moved = self.moved(odometry)
        due = self._is_due(moved)
        if due:
            self.advance(odometry)
            self.integrity = propagate_claim(self.integrity, moved)
        return due

    def update(self, odometry: Pose2, scan: Scan) -> Estimate | None:
        """Update the filter with a scan.

        Args:
            odometry: the robot in the odom frame, at the scan's stamp.

        Returns:
            The estimate; None if the robot has hardly moved since the last scan, or if nothing is
            known.
        """
        self.seen = self.trusted(scan)
        moved = self.moved(odometry)
        if not (self._forced or self._is_due(moved)):
            self._watch(moved, self.seen)
            return None
        if self._was_certain and not self._still_fits:
            self._search_anew()
        known = self._on_seen_floor(moved, self.seen)
        self.advance(odometry)
        self.filter.correct(known)
        return self.conclude(odometry, known)

    def advance(self, odometry: Pose2) -> Pose2:
        """Move the belief by all of the odometry since it was last moved; return the step."""
        moved = self.moved(odometry)
        if self.monitor is not None:
            moved = self.monitor.corrected_step(moved)
        # The odometry of the last step advances only with a prediction, so no motion is lost.
        self._odometry = odometry
        for each in self._filters:
            each.predict(moved)
        # What was concluded was of the place before this step.
        self._concluded, self._was_certain, self._still_fits = (), False, True
        return moved

    def trusted(self, scan: Scan) -> Scan:
        """Return a scan as the filter takes it: ranges that are trusted, the camera's tilt off."""
        seen = scan.within(*self.reach)
        return seen if self.monitor is None else self.monitor.corrected(seen)

    def _on_seen_floor(self, moved: Pose2, seen: Scan) -> Scan:
        """Return a scan without what a place that nothing denies says nothing of, after a step."""
        if self.monitor is None or not self._concluded:
            return seen
        place = self._concluded[0].pose
        undoubted = self._standing(place) in (Standing.CONFIRMED, Standing.GIVEN)
        return self.monitor.on_seen_floor(seen, place @ moved) if undoubted else seen

    def conclude(self, odometry: Pose2, seen: Scan) -> Estimate | None:
        """Return the estimate after a scan was weighed, refined and checked; and claim it."""
        self._forced = False
        self.updates += 1
        if self.beside is not None:
            self.beside.filter.correct(seen)
        estimate = self.estimate(seen.stamp)
        if estimate is None:
            return None
        heaviest = estimate.hypotheses[0]
        if self.refinement is not None:
            heaviest = self.refinement.refine(heaviest, seen)
        if self.monitor is not None:
            spread = estimate.effective / max(len(self.filter.cloud.weights), 1)
            self.monitor.observe(heaviest, seen, odometry, spread)
            if self.monitor.contradicted:
                self._search_anew()
            for each in self._filters:
                each.loosen(self.monitor.looseness)
            heaviest = self.monitor.compensate_lateness(heaviest)
            heaviest = replace(
                heaviest, covariance=heaviest.covariance + self.monitor.doubt.covariance
            )
        estimate = replace(estimate, hypotheses=(heaviest, *estimate.hypotheses[1:]))
        self._concluded = estimate.hypotheses
        self.integrity = self._claim()
        fitted = self.monitor is None or self.monitor.newest_fits
        self._was_certain = fitted and self.integrity.state in BOUNDED
        # A cloud around a given start narrows by some scans, also while the robot stands.
        self._forced = not fitted and self._standing(heaviest.pose) is Standing.GIVEN
        return estimate

    def estimate(self, stamp: float) -> Estimate | None:
        """Return the filter's current estimate; None while nothing is known."""
        hypotheses = self.filter.hypotheses
        if not hypotheses:
            self.integrity = SEARCHING
        return Estimate(stamp, hypotheses, self.filter.effective) if hypotheses else None

    def _watch(self, moved: Pose2, seen: Scan) -> None:
        """Claim less if a scan that is not due does not fit: something has changed."""
        if self.monitor is not None and self._concluded:
            self._still_fits = self.monitor.watch(self._concluded[0].pose @ moved, seen)
            self.integrity = self._claim()

    def _claim(self) -> Integrity:
        doubt = NO_DOUBT if self.monitor is None else self.monitor.doubt
        standing = self._standing(self._concluded[0].pose) if self._concluded else None
        return claim(self._concluded, standing or self.filter.standing, doubt)

    def _standing(self, pose: Pose2) -> Standing:
        return self.filter.standing if self.beside is None else self.beside.standing_at(pose)

    @property
    def _filters(self) -> tuple[Filter, ...]:
        return (self.filter,) if self.beside is None else (self.filter, self.beside.filter)

    def _search_anew(self) -> None:
        for each in self._filters:
            each.search_anew()

    def _restart(self) -> None:
        self.updates, self._concluded = 0, ()
        self._was_certain, self._still_fits = False, True
        self.integrity = SEARCHING
        if self.monitor is not None:
            self.monitor.restart()
        # The new belief is about the robot's current place: it already includes earlier motion.
        self._odometry = self.now
        self._forced = True

    def moved(self, odometry: Pose2) -> Pose2:
        """Return the motion by odometry since the belief was last moved."""
        if self._odometry is None:
            self._odometry = odometry
        return self._odometry.inverse() @ odometry

    def _is_due(self, moved: Pose2) -> bool:
        far = math.hypot(moved.x, moved.y) >= self.parameters.update_min_d
        return far or abs(moved.theta) >= self.parameters.update_min_a


def make_filter(setup: Setup, rng: np.random.Generator) -> Filter:
    """Return the filter that the parameters name, at the field's start pose."""
    return FILTERS[setup.filter.filter].make(setup, rng)


def search_beside(setup: Setup, searching: Filter | None = None) -> SearchBeside | None:
    """Return what searches beside a setup's filter; None if that searches, or is of a laser."""
    alone = FILTERS[setup.filter.filter].has_hypotheses or not setup.field.tape
    name = "robot.localization.search_beside:SearchBeside"  # by name: few filters need it
    return None if alone else resolve_name(name)(setup, searching)


def transfer_belief(new: Filter, old: Filter) -> Filter:
    """Give a new filter the belief of an old one, and return it."""
    said = old.hypotheses
    if sum(item.weight for item in said) >= MIN_DESCRIBED_WEIGHT:
        new.set_hypotheses(said)
    else:
        new.set_cloud(old.cloud)
    return new
