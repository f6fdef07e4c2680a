"""Turns camera pictures into estimates by scanner and filter; parameters may change live."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from app.engine.added_models import AddedModels, ModelChoice, choice_of
from app.engine.earlier_beliefs import EarlierBeliefs
from app.engine.filter_models import FilterModels
from app.engine.follower import FilterState, Follower
from app.engine.steps_by_hand import StepsByHand
from robot.description.spec import RobotSpec
from robot.driving.odometry import OdometryState
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Frame
from robot.localization.estimate import Alert, Belief, Estimate, Hypothesis, Integrity
from robot.localization.filter import Cloud, Setup
from robot.localization.localizer import Localizer, make_filter
from robot.localization.models.entry_field import EntryField
from robot.localization.monitoring.claims import propagate_claim
from robot.localization.monitoring.monitor import Monitor
from robot.localization.monitoring.mounting_check import CameraPosition
from robot.localization.monitoring.steady_errors import SteadyErrors
from robot.localization.parameters import LocalizationParameters
from robot.localization.weighing import Weighing
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan, LineScanner


class Localization(Follower):
    """Owns scanner and filter; one thread calls it."""

    needs_camera = True

    def __init__(
        self,
        scanner: LineScanner,
        field: Field,
        parameters: LocalizationParameters,
        rng: np.random.Generator,
        *,
        added: tuple[AddedModels, ...] = (),
        entries: EntryField | None = None,
        start: tuple[Hypothesis, ...] = (),
        configured: LocalizationParameters | None = None,
        spec: RobotSpec | None = None,
    ) -> None:
        """Make the filter and put it at the start.

        Args:
            scanner: finds tape in pictures.
            field: the map.
            parameters: parameters of models and filter.
            rng: random generator of the filter alone.
            added: models of features; by default none.
            entries: the table of distances; by default it is made from the field, which takes up
                to some seconds.
            start: where the filter starts, and where ``reset`` puts it; empty is the field's start
                with the filter's own spread.
            configured: the parameters that ``reset`` restores; by default ``parameters``.
            spec: the robot, for what its calibration leaves open; by default nobody measured it.
        """
        self.scanner = scanner
        self.line_scan: LineScan | None = None
        """What the scanner found in the last picture."""
        self.paused = False
        self.added = added
        self.parameters = parameters
        self._make_added(fresh=True)
        self.configured = configured or parameters
        """The parameters that ``reset`` restores."""
        self.seconds = 0.0
        """Processor time of the filter's last update [s]."""
        self._start = start
        self._field = field
        self._rng = rng
        self._once = False
        self.earlier = EarlierBeliefs()
        self.by_hand = StepsByHand()
        self.newest: tuple[Scan, Pose2] | None = None
        """The newest scan, and odometry at its stamp; None before the first."""
        self._weighing: Weighing | None = None
        self._weighed_by: tuple[object, ...] = ()
        """What ``_weighing`` was made from."""
        self.remarks: tuple[Alert, ...] = ()
        """Reasons for doubt besides those that the monitor finds."""
        self.models = FilterModels(field, entries)
        """Of sensor and motion, and their table of distances."""
        setup = self._setup()
        self._monitor = self._monitor_of(setup, spec)
        self.localizer = Localizer.of(make_filter(setup, rng), setup, self._monitor)
        if start:
            self._begin()

    @property
    def cloud(self) -> Cloud:
        """The particles with their newest weights; by hand, as they stand."""
        return self.by_hand.particles or self.localizer.filter.cloud

    @property
    def shown(self) -> FilterState:
        """What scanner and filter show of themselves now."""
        return FilterState(
            scanner=self.scanner,
            line_scan=self.line_scan,
            cloud=self.cloud,
            weighing=self._weigh_newest(),
            hand=self.by_hand.state(self.newest and self.newest[1]),
            paused=self.paused,
            updates=self.localizer.updates,
            undoable=len(self.earlier),
            parameters=self.parameters,
            models=choice_of(self.added),
            fault=self.fault,
            trace=next((models.trace for models in self.added if models.trace), ""),
        )

    def _weigh_newest(self) -> Weighing | None:
        seen, newest = self.localizer.seen, self.newest
        if seen is None or newest is None:
            return None
        scan, odometry = self.by_hand.seen or (seen, newest[1])
        extra = self.localizer.filter.extra_sd
        power = self.parameters.sensor.likelihood_weight
        # Snapshots ask for it 50 times a second; it is another one only after a picture or command.
        known = scan, extra, self.models.sensor, power, self.belief, odometry
        if not _are_same(known, self._weighed_by):
            self._weighed_by = known
            best = None if self.belief is None else self.belief.pose(odometry)
            seen = replace(scan, extra_sd=extra)
            self._weighing = Weighing(seen, self.models.sensor, power, best)
        return self._weighing

    @property
    def integrity(self) -> Integrity:
        """State, bounds and alerts of the newest estimate, at the stamp of its scan."""
        claim = self.localizer.integrity
        alerts = tuple(alert for models in self.added for alert in models.alerts)
        return claim.because_of(alerts) if alerts else claim

    def integrity_at(self, odom_from_robot: Pose2) -> Integrity:
        """Return the integrity of the estimate carried forward: odometry adds its errors."""
        moved = self.belief.moved(odom_from_robot) if self.belief else Pose2()
        claim = propagate_claim(self.integrity, moved)
        return replace(claim, alerts=self.remarks + claim.alerts) if self.remarks else claim

    @property
    def settled(self) -> bool:
        """Whether more pictures tell the filter nothing new while the robot stands."""
        return self.belief is not None and not self.by_hand.enabled and self.localizer.settled

    def note(self, odom_from_robot: Pose2) -> None:
        """Note the present odometry pose, before commands that may set the filter's pose."""
        self.localizer.now = odom_from_robot

    def measure(self, seen: Frame | Scan, odometry: OdometryState) -> None:
        """Update the filter with a picture or a laser's scan, and the odometry at its stamp."""
        if isinstance(seen, Frame):
            self.line_scan = self.scanner.scan(seen, odometry.twist)
            seen = self.line_scan.scan
        self.take(seen, odometry.odom_from_robot)

    def take(self, scan: Scan, pose: Pose2) -> None:
        """Update the filter with a scan, and the odometry's pose at its stamp."""
        self._monitor.of_clearing = np.zeros((3, 3))
        for models in self.added:
            scan = models.cleared(scan, pose)
            models.advise(self._monitor)
        self.newest = scan, pose
        if self.by_hand.enabled:
            return
        if self.fault or (self.paused and not self._once):
            self.localizer.seen = self.localizer.trusted(scan)
            # If the cloud has not moved, keep the earlier estimate and its odometry.
            if self.localizer.predict(pose) or self.belief is None:
                self._believe(self.localizer.estimate(scan.stamp), pose)
            return
        self._once = False
        before, began = self.localizer.updates, time.thread_time()
        estimate = self.localizer.update(pose, scan)
        self.seconds = time.thread_time() - began
        if self.localizer.updates > before:
            self.note_update()
        self._believe(estimate, pose)

    def note_update(self) -> None:
        """Tell models of features that the filter has taken a scan."""
        for models in self.added:
            models.note_update()

    def set_pose(self, pose: Pose2, covariance: Array | None = None) -> None:
        """Tell the filter where the robot is, with a covariance (3, 3) [m, m, rad] or the usual."""
        usual = self.parameters.filter.initial_covariance
        self.localizer.set_pose(pose, usual if covariance is None else covariance)
        self._restarted()

    def set_cloud(self, cloud: Cloud) -> None:
        """Start the filter from weighted poses."""
        self.localizer.set_cloud(cloud)
        self._restarted()

    def scatter(self) -> None:
        """Start the filter scattered: the robot may be anywhere on the field."""
        self.localizer.scatter()
        self._restarted()

    def keep_belief(self) -> None:
        """Keep the belief before it is changed, for ``undo``."""
        self.earlier.keep(self.parts, self.unchanging)

    def undo(self) -> None:
        """Restore the belief before its last change, which odometry has moved since."""
        odom_from_robot = self.localizer.now
        self.put_back(self.earlier.restore())
        self.localizer.now = odom_from_robot
        self.by_hand.restart(self.localizer)

    @property
    def parts(self) -> tuple[Any, ...]:
        """All that a belief consists of."""
        return self.localizer, self._monitor, self.belief, self._rng

    @property
    def unchanging(self) -> tuple[Any, ...]:
        """What copies of a belief share."""
        in_use = (model for models in self.added for model in models.in_use)
        return self._field, self._field.edges, *self.added, *in_use

    def put_back(self, parts: tuple[Any, ...]) -> None:
        """Go on from a belief that was kept."""
        self.localizer, self._monitor, self.belief, self._rng = parts
        self.use(self.parameters)

    def update_once(self) -> None:
        """Update with the next picture, even if the filter is paused or the robot stands."""
        self._once = True
        self.localizer.force_update()

    def use_robot(self, spec: RobotSpec) -> None:
        """Follow a robot that was calibrated anew; the filter keeps its belief."""
        self.scanner = self.scanner.seen_through(spec.floor_view)
        self.line_scan = None
        # What was found of the camera's and the wheels' errors was of the robot before.
        self._monitor = self._monitor_of(self._setup(), spec)
        self.localizer.monitor = self._monitor
        self.earlier.clear()
        self.by_hand.restart(self.localizer)

    def reset(self) -> None:
        """Restore the configured parameters and models, and start the filter again."""
        self.choose(None, self.configured)
        self.paused = self._once = False
        self.by_hand.switch(None)
        self._begin()

    def _begin(self) -> None:
        """Put the filter at its start."""
        if not self._start:
            self.set_pose(self._field.start)
        elif len(self._start) == 1:
            self.set_pose(self._start[0].pose, self._start[0].covariance)
        else:
            self.localizer.set_hypotheses(self._start)
            self._restarted()

    def _restarted(self) -> None:
        """Drop what was said of the belief that is no more."""
        self.belief = None
        self.by_hand.restart(self.localizer)

    def choose(self, choice: ModelChoice | None, parameters: LocalizationParameters) -> None:
        """Change models, None to those of the start, and parameters; the belief is kept."""
        for models in self.added:
            models.choose(choice)
        self.use(parameters)

    def reload(self) -> None:
        """Load models of features again, and update the filter with the next picture."""
        self._make_added(fresh=True)
        self.use(self.parameters)
        self.localizer.force_update()

    def use(self, parameters: LocalizationParameters) -> None:
        """Change the parameters; the filter keeps its belief."""
        other = parameters.filter.filter != self.localizer.parameters.filter
        self.parameters = parameters
        self._make_added(fresh=False)
        setup = self._setup()
        if other:
            self.by_hand.switch(None)
            self.localizer.exchange(make_filter(setup, self._rng), setup)
            # The new filter may know less than the old one, so drop the old estimate.
            self.belief = None
            self.localizer.force_update()
        else:
            self.localizer.filter.use(setup)
            self.localizer.use(setup)
        self._monitor.use(setup.evidence, model_suspected=not self.models.usual)

    def _make_added(self, *, fresh: bool) -> None:
        for models in self.added:
            models.make(self.parameters, fresh=fresh)

    def _believe(self, estimate: Estimate | None, pose: Pose2) -> None:
        if estimate is not None:
            self.belief = Belief(estimate, pose)

    def _monitor_of(self, setup: Setup, spec: RobotSpec | None) -> Monitor:
        return Monitor(
            setup.evidence,
            CameraPosition.of(self.scanner.view),
            SteadyErrors.of(spec),
            model_suspected=not self.models.usual,
        )

    def _setup(self) -> Setup:
        return self.models.setup(self.parameters, self.added)


def _are_same(parts: tuple[object, ...], others: tuple[object, ...]) -> bool:
    """Whether two tuples hold the very same objects; arrays are not compared."""
    return len(parts) == len(others) and all(a is b for a, b in zip(parts, others, strict=True))
