"""Statistics and fit on scans of a simulated drive, with false and missing returns planted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.features.lab.evaluation.drives import Drive, record
from app.features.lab.model_fits.beam_correlation import correlate_beams
from app.features.lab.model_fits.beam_fit import fit_sensor
from app.features.lab.model_fits.range_pairs import (
    FAR_OFF,
    RangePairs,
    by_bearing,
    by_distance,
    overall,
    pair_ranges,
)
from app.settings.config import Config
from robot.geometry import Pose2
from robot.scan import Scan

SECONDS = 3.0
RANGE_MAX = 1.0
FALSE, MISSING = 0.03, 0.04


@pytest.fixture(scope="module")
def drive() -> Drive:
    return record(Config(robot="kinematic", seed=0), SECONDS)


@pytest.fixture(scope="module")
def scans(drive: Drive) -> list[Scan]:
    return [tick.scan for tick in drive.ticks if tick.scan is not None]


@pytest.fixture(scope="module")
def truth(drive: Drive, scans: list[Scan]) -> list[Pose2]:
    return [drive.truth_at(scan.stamp) for scan in scans]


@pytest.fixture(scope="module")
def pairs(drive: Drive, scans: list[Scan], truth: list[Pose2]) -> RangePairs:
    return pair_ranges(drive.field, scans, truth, RANGE_MAX)


def test_ranges_are_right_to_a_part_of_a_millimetre(pairs: RangePairs) -> None:
    found = overall(pairs)
    assert found.count > 4000
    assert abs(found.bias) < 1e-4
    assert found.sd < 1e-3
    assert found.robust_sd < 2e-4
    assert found.missed < 0.02
    assert found.false < 0.002
    for one in by_distance(pairs, np.arange(0.1, 1.05, 0.1)) + by_bearing(
        pairs, np.linspace(-0.6, 0.6, 7)
    ):
        assert one.count < 100 or abs(one.bias) < 1e-3


def test_poses_that_are_a_centimetre_off_are_noticed(
    drive: Drive, scans: list[Scan], truth: list[Pose2]
) -> None:
    off = pair_ranges(drive.field, scans, [pose @ Pose2(0.01) for pose in truth], RANGE_MAX)
    assert overall(off).bias > 0.004


@pytest.fixture(scope="module")
def planted(pairs: RangePairs) -> RangePairs:
    """Of the rays, some return anything that they can see, and some nothing."""
    rng = np.random.default_rng(1)
    chance = rng.random(len(pairs))
    near, far = pairs.sight.T
    anything = rng.uniform(near, far)
    false = (chance < FALSE) & (np.abs(anything - pairs.expected) > FAR_OFF)
    measured = np.where(false, anything, pairs.measured)
    measured[(chance > 1 - MISSING) & pairs.sure] = np.inf
    return replace(pairs, measured=measured)


def test_planted_false_and_missing_returns_are_counted(
    pairs: RangePairs, planted: RangePairs
) -> None:
    rng_false = np.isfinite(planted.measured) & (planted.measured != pairs.measured)
    before, after = overall(pairs), overall(planted)
    false = round(after.false * after.returns) - round(before.false * before.returns)
    assert false == rng_false.sum() - (rng_false & pairs.returned & ~pairs.right).sum()
    gone = pairs.sure & pairs.right & ~planted.right
    missed = round(after.missed * after.expected) - round(before.missed * before.expected)
    assert missed == gone.sum()
    assert after.bias == pytest.approx(before.bias, abs=2e-5)


def test_planted_false_and_missing_returns_are_fitted(
    pairs: RangePairs, planted: RangePairs
) -> None:
    fit = fit_sensor(planted, RANGE_MAX, least_sigma=0.0005)
    values, fitted = fit.values, planted.sure | planted.empty
    assert fit.converged
    missing = MISSING + overall(pairs).missed
    assert values.z_max / (values.z_max + values.z_hit) == pytest.approx(missing, abs=0.005)
    near, far = planted.sight[fitted].T
    fades = np.exp(-values.lambda_short * np.array([near, np.fmin(planted.expected[fitted], far)]))
    expected = values.z_rand * (far - near).sum() + values.z_short * (fades[0] - fades[1]).sum()
    false = planted.returned & (planted.measured != pairs.measured)
    assert expected == pytest.approx((false & fitted).sum(), rel=0.15)


def test_neighbouring_rays_of_a_picture_err_together(pairs: RangePairs) -> None:
    found = correlate_beams(pairs, 60, resamples=50)
    assert 0.5 < found.by_ray[1] < 1
    assert 0.02 < found.likelihood_weight < 0.5
    assert found.likelihood_weight_of_successive_scans <= found.likelihood_weight
