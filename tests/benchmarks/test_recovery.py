"""Random particles come in when scans fit worse than they used to (augmented MCL)."""

from __future__ import annotations

import numpy as np
import pytest
from particle_robot import sensor_named, tracker_of

from robot.geometry import Array, Pose2
from robot.localization.models.sensor_models import SENSOR_MODELS, SensorModel
from robot.localization.particles.resampling import Recovery
from robot.scan import Scan

EVEN = np.full(10, 0.1)


def observed(*levels: float, rays: int = 60, slow: float = 0.01, fast: float = 0.2) -> Recovery:
    """After scans of which each ray had a likelihood."""
    found = Recovery()
    for level in levels:
        found.observe(np.full(10, rays * np.log(level)), EVEN, rays, slow, fast)
    return found


def test_the_first_scan_sets_both_averages() -> None:
    assert observed(0.4).slow == observed(0.4).fast == pytest.approx(0.4)
    assert observed(0.4).share() == 0


def test_while_scans_fit_as_ever_or_better_nothing_is_tried() -> None:
    assert observed(*[0.4] * 30).share() == pytest.approx(0, abs=1e-12)
    assert observed(*[0.2] * 10, *[0.8] * 30).share() == 0


def test_when_scans_fit_worse_the_share_is_that_of_the_book() -> None:
    slow, fast = 0.5 + 0.01 * (0.1 - 0.5), 0.5 + 0.2 * (0.1 - 0.5)
    assert observed(0.5, 0.1).share() == pytest.approx(1 - fast / slow)


def test_either_alpha_of_zero_turns_it_off() -> None:
    assert observed(0.5, 0.01, slow=0.0).share() == observed(0.5, 0.01, fast=0.0).share() == 0


def test_scans_with_few_rays_and_with_many_compare() -> None:
    found = Recovery()
    for rays in (60, 7, 33):
        found.observe(np.full(10, rays * np.log(0.3)), EVEN, rays, 0.01, 0.2)
    assert found.fast == pytest.approx(0.3)


class OwnModel:
    """A user's: it sums over all rays that returned."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Each fits as well."""
        return np.full(len(poses), np.log(0.3) * scan.hit.sum())


MODELS = [*map(sensor_named, SENSOR_MODELS), OwnModel()]


@pytest.mark.parametrize("model", MODELS, ids=[*SENSOR_MODELS, "own"])
@pytest.mark.parametrize("lost", [False, True])
def test_rays_that_fit_alike_have_the_same_average_however_many(
    model: SensorModel, lost: bool
) -> None:
    """Also beyond those that the model may use; every third may find nothing."""
    averages = []
    for rays in (30, 60, 91, 181):
        f = tracker_of(model, recovery_alpha_slow=0.1, recovery_alpha_fast=0.2)
        f.told(Pose2(), 0.005, 0.01)
        ranges = np.full(rays, 0.35)
        ranges[1::3] = np.inf if lost else 0.35
        f.update(Pose2(), Scan(0.0, np.zeros(rays), ranges))
        averages.append(f.filter._recovery.fast)
    assert averages == pytest.approx(4 * [averages[0]], rel=0.03 if lost else 1e-4)


def test_particles_count_by_their_weight() -> None:
    found = Recovery()
    weights = np.array([0.75, 0.25])
    found.observe(10 * np.log([0.8, 0.4]), weights, 10, 0.1, 0.1)
    assert found.slow == pytest.approx(0.75 * 0.8 + 0.25 * 0.4)


class Level:
    """A model by which every pose fits alike, each ray with the same likelihood."""

    def __init__(self) -> None:
        self.ray = 0.5

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        return np.full(len(poses), np.log(self.ray) * scan.hit.sum())


def test_a_fall_counts_once() -> None:
    """Else scans that fit worse from now on would end with all particles anywhere."""
    model = Level()
    f = tracker_of(model, recovery_alpha_slow=0.01, recovery_alpha_fast=0.2, resample_interval=1)
    f.told(Pose2(), 0.005, 0.01)
    anywhere = []
    for ray in (0.5, 0.1, 0.1, 0.1):
        model.ray = ray
        f.force_update()
        f.update(Pose2(), Scan(0.0, np.zeros(60), np.full(60, 0.35)))
        anywhere.append(float(np.mean(np.hypot(*f.cloud.poses[:, :2].T) > 0.05)))
    assert anywhere[0] == 0
    assert anywhere[1:] == pytest.approx(3 * [observed(0.5, 0.1).share()], abs=0.03)
