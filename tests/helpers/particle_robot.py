"""A particle filter fed by odometry and scans as a robot feeds it, with its particles at hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, Drive

from robot.fields.edges import outline
from robot.geometry import Pose2
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.localizer import Localizer
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import SensorModel, sensor_model
from robot.localization.particles.particle_filter import ParticleFilter

WALL = replace(STUB, edges=outline(shapely.box(-9, 0.475, 9, 0.525)))
"""One straight piece of tape: it says nothing of where along it the robot is."""

WALL_SENSOR = sensor_model(
    DEFAULTS.sensor, EntryField.build(WALL, resolution=0.005, max_distance=0.15), WALL.edges
)


def sensor_named(name: str) -> SensorModel:
    return sensor_model(replace(DEFAULTS.sensor, laser_model_type=name), ENTRIES, STUB.edges)


class Tracker(Localizer):
    filter: ParticleFilter

    @property
    def cloud(self) -> Cloud:
        """After resampling."""
        return self.filter._particles

    def told(self, pose: Pose2, sd_xy: float, sd_theta: float) -> None:
        self.set_pose(pose, np.diag(np.square([sd_xy, sd_xy, sd_theta])))


def tracker_of(sensor: SensorModel = SENSOR, seed: int = 0, **changes: float) -> Tracker:
    parameters = replace(DEFAULTS.filter, **changes)
    rng, share = np.random.default_rng(seed), DEFAULTS.sensor.likelihood_weight
    made = ParticleFilter(
        DEFAULTS.motion.model(), sensor, STUB, parameters, rng, likelihood_weight=share
    )
    return Tracker(made, parameters)


def track(f: Tracker, drive: Drive, seconds: float) -> list[tuple[Estimate, float, float]]:
    """Estimates along the figure-eight, and how far they are off [m] and [rad]."""
    found = []
    for _, scan in drive.eight(seconds):
        estimate = f.update(drive.odometry, scan)
        if estimate is not None:
            pose = estimate.pose
            found.append((estimate, pose.distance_to(drive.true), abs(pose.turn_to(drive.true))))
    return found


def still(f: Tracker, odometry: Pose2 = Pose2()) -> Estimate | None:
    """A scan from the origin, with odometry that says something or nothing."""
    return f.update(odometry, Drive(rng=np.random.default_rng(0)).scan())


def standing_tracker() -> Tracker:
    """It has taken its first scan."""
    f = tracker_of()
    f.told(Pose2(), 0.02, 0.05)
    assert still(f) is not None
    return f
