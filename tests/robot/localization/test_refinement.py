"""Refinement: the estimate is laid on the edges, where it is close enough to know on which."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, Drive, noisy_scan

from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Setup
from robot.localization.parameters import LocalizationParameters
from robot.localization.refinement import (
    DRAWN,
    FEWEST_BEAMS,
    INEXACT,
    MEAN_ERROR,
    NEAR_SHARE,
    WIDEST,
    Refinement,
)
from robot.localization.scan_matching import GATE_SDS, SLOPE

SD = DEFAULTS.sensor.sigma_hit
NARROW = np.diag(np.square([0.002, 0.002, 0.008]))


def refinement(parameters: LocalizationParameters = DEFAULTS) -> Refinement | None:
    return Refinement.of(Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, parameters))


def made() -> Refinement:
    one = refinement()
    assert one is not None
    return one


def test_it_is_there_if_asked_for_and_has_the_sensors_figures() -> None:
    assert refinement(replace(DEFAULTS, filter=replace(DEFAULTS.filter, refine=False))) is None
    matcher = made().matcher
    assert matcher.sd == NEAR_SHARE * SD and matcher.slope == SLOPE
    assert matcher.gate == GATE_SDS * SD and matcher.range_max == DEFAULTS.sensor.laser_max_range
    assert matcher.edge_index is STUB.edge_index


def test_it_uses_more_rays_than_the_filter_but_never_fewer() -> None:
    def beams(most: int) -> int:
        one = refinement(replace(DEFAULTS, sensor=replace(DEFAULTS.sensor, max_beams=most)))
        assert one is not None
        return one.max_beams

    assert beams(60) == FEWEST_BEAMS > 60 and beams(300) == 300


def test_it_takes_away_the_luck_of_the_draws() -> None:
    """Estimates that err by some millimetres, along a drive; along a single side they stay so."""
    rng, drive, one = np.random.default_rng(0), Drive(), made()
    before, after, turned, turned_after = [], [], [], []
    for _, scan in drive.eight(3.0):
        off = rng.normal(0, [0.002, 0.002, 0.008])
        rough = Hypothesis(0.7, Pose2.from_array(drive.true.to_array() + off), NARROW)
        fine = one.refine(rough, scan)
        before.append(rough.pose.distance_to(drive.true))
        after.append(fine.pose.distance_to(drive.true))
        turned.append(abs(rough.pose.turn_to(drive.true)))
        turned_after.append(abs(fine.pose.turn_to(drive.true)))
    assert np.mean(after) < 0.5 * np.mean(before)
    assert np.mean(turned_after) < 0.4 * np.mean(turned)


def test_a_laser_measures_as_exactly_as_it_is_said_to_however_far() -> None:
    walls = replace(STUB, tape=())
    setup = Setup.of(walls, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)
    one = Refinement.of(setup)
    assert one is not None and one.matcher.sd == SD and one.matcher.slope == 0


def test_its_weight_stays_that_of_the_filter_and_its_covariance_is_its_own() -> None:
    rough = Hypothesis(0.7, Pose2(0.002, -0.001, 0.01), NARROW)
    fine = made().refine(rough, Drive().scan())
    assert fine.pose != rough.pose and fine.weight == 0.7
    # One side is ahead: x and heading are measured, y is not.
    before, after = (np.sqrt(np.diag(one.covariance)) for one in (rough, fine))
    assert after[0] < 0.1 * before[0] and after[2] < 0.1 * before[2]
    # Along what the scan says nothing of a cloud is narrower than it should be.
    wider = math.sqrt(DRAWN * before[1] ** 2 + MEAN_ERROR[1, 1])
    assert after[1] == pytest.approx(wider, rel=0.05)


def test_its_covariance_is_honest() -> None:
    """For scans whose ends err as believed, a cloud as wide as allowed for, an inexact drawing."""
    rng, one, squared = np.random.default_rng(0), made(), []
    sd = one.matcher.sd / math.sqrt(one.believed)
    for _ in range(150):
        true = Pose2(*rng.uniform(-0.15, 0.15, 2), rng.uniform(-3, 3))
        scan = noisy_scan(true, sd, rng)
        spread = np.where(scan.hit, 1 + SLOPE * np.nan_to_num(scan.ranges, posinf=0) ** 2, 1)
        exact = noisy_scan(true, 0.0, rng).ranges
        with np.errstate(invalid="ignore"):
            ranges = np.where(scan.hit, exact + spread * (scan.ranges - exact), np.inf)
        off = rng.normal(0, np.sqrt(np.diag(DRAWN * NARROW + MEAN_ERROR)))
        rough = Hypothesis(1.0, Pose2.from_array(true.to_array() + off), NARROW)
        fine = one.refine(rough, replace(scan, ranges=ranges))
        error = fine.pose.to_array() - true.to_array()
        error[2] = true.turn_to(fine.pose)
        error += rng.normal(0, np.sqrt(np.diag(INEXACT)))
        squared.append(error @ np.linalg.solve(fine.covariance, error))
    # Half of the errors of an honest one are below 2.4.
    assert 1.8 < np.median(squared) < 3.0


def test_what_is_known_better_than_a_scan_tells_hardly_moves() -> None:
    """Before one side, along which the scan tells nothing, and from far off the edge."""
    rough = Hypothesis(1.0, Pose2(0.0005, 0.0, 0.0), np.diag([1e-12, 1e-12, 1e-12]))
    tight, loose = (
        made().refine(replace(rough, covariance=covariance), Drive().scan()).pose
        for covariance in (rough.covariance, NARROW)
    )
    assert abs(loose.x) < abs(tight.x) < 0.0005


def test_a_cloud_that_has_become_too_narrow_is_mended_all_the_same() -> None:
    """Its mean may be off by the luck of its draws, whatever its spread says."""
    drawn_together = Hypothesis(1.0, Pose2(0.002, 0.0, 0.0), np.diag([1e-9, 1e-9, 1e-9]))
    assert abs(made().refine(drawn_together, Drive().scan()).pose.x) < 0.001


def test_a_wide_hypothesis_is_left_alone() -> None:
    """Its mean may lie between two places."""
    one, scan = made(), Drive().scan()
    for axis in range(2):
        variances = np.square([0.001, 0.001, 0.01])
        variances[axis] = (1.01 * WIDEST * SD) ** 2
        wide = Hypothesis(1.0, Pose2(0.003, 0.002, 0.01), np.diag(variances))
        assert one.refine(wide, scan) is wide
        variances[axis] = (0.99 * WIDEST * SD) ** 2
        assert one.refine(replace(wide, covariance=np.diag(variances)), scan).pose != wide.pose


def test_a_scan_that_does_not_fit_here_moves_nothing() -> None:
    away = Hypothesis(1.0, Pose2(0.65, 0.65, 0.8), NARROW)
    assert made().refine(away, Drive().scan()).pose == away.pose
