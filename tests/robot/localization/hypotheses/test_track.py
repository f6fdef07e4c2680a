"""A hypothesis is weighed where its scan fits, not where the luck of its particles put it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from stub_drive import DEFAULTS, ENTRIES, SENSOR, STUB, Drive

from robot.geometry import Pose2
from robot.localization.filter import Setup
from robot.localization.hypotheses.track import ONE_THING, STUCK, Track
from robot.localization.parameters import HypothesisParameters
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import rays_of

SETUP = Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)
TRUE = Pose2(-0.1, 0.1, 2.3)
NARROW = np.diag(np.square([0.001, 0.001, 0.003]))
RAYS = rays_of(Drive(TRUE).scan(), 60)


def track_at(pose: Pose2) -> Track:
    one = ParticleFilter.of(SETUP, np.random.default_rng(0))
    one.set_pose(pose, NARROW)
    return Track(one, 0.0)


def fit(pose: Pose2) -> float:
    return track_at(pose).fit(RAYS, SETUP)


def test_its_pose_is_that_of_its_heaviest_hypothesis() -> None:
    track = track_at(TRUE)
    assert track.best.pose == track.pose == track.filter.hypotheses[0].pose


@pytest.mark.parametrize("off", [Pose2(0.004, -0.003, 0.01), Pose2(-0.004, 0.005, -0.015)], ids=str)
def test_a_few_millimetres_off_it_fits_as_well(off: Pose2) -> None:
    """Where unpolished poses would differ by more than places do."""
    assert fit(TRUE @ off) == pytest.approx(fit(TRUE), abs=0.01)
    rough = SETUP.evidence.log_likelihood(TRUE @ off, RAYS)
    assert rough < fit(TRUE) - 0.03


def test_polished_or_not_elsewhere_does_not_fit() -> None:
    for off in (Pose2(0.1, 0.1, 0.3), Pose2(-0.15, 0, 1.0)):
        assert fit(TRUE @ off) < fit(TRUE) - 1


@pytest.mark.parametrize("off", [Pose2(0.04, 0, 0), Pose2(0, 0.04, 0.05)], ids=str)
def test_known_to_centimetres_it_fits_where_rays_lie_farther_off_than_half_the_tape(
    off: Pose2,
) -> None:
    one = ParticleFilter.of(SETUP, np.random.default_rng(0))
    one.set_pose(TRUE @ off, np.diag(np.square([0.03, 0.03, 0.05])))
    assert Track(one, 0.0).fit(RAYS, SETUP) == pytest.approx(fit(TRUE), abs=0.01)


@pytest.mark.parametrize("off", [Pose2(0.06, 0, 0), Pose2(0, 0.04, 0.1)], ids=str)
def test_it_does_not_live_on_what_fits_another_place(off: Pose2) -> None:
    """From so near, rays would draw it over, millimetres though its filter is sure of.

    A match that stops on the way, as no step lowers its cost, fits hardly better than where it was.
    """
    track = track_at(TRUE @ off)
    rough = SETUP.evidence.log_likelihood(track.pose, RAYS)
    assert track.fit(RAYS, SETUP) == pytest.approx(rough, abs=0.02)
    assert rough < fit(TRUE) - 1


def test_surer_than_it_should_be_it_begins_anew_where_scans_fit() -> None:
    off = Pose2(TRUE.x + 0.018, TRUE.y + 0.018, TRUE.theta + 0.03)
    track = track_at(off)
    for scans in range(1, STUCK + 1):
        track.fit(RAYS, SETUP)
        track.restart_if_stuck()
        held = track.pose.distance_to(off) < 0.003
        assert held == (scans < STUCK)
    assert track.pose.distance_to(TRUE) < 0.5 * off.distance_to(TRUE)


def test_one_scan_that_fits_elsewhere_does_not_move_it() -> None:
    off = Pose2(TRUE.x + 0.018, TRUE.y + 0.018, TRUE.theta + 0.03)
    track = track_at(off)
    here = rays_of(Drive(off).scan(), 60)
    for rays in (RAYS, RAYS, here, RAYS, RAYS):
        track.fit(rays, SETUP)
        track.restart_if_stuck()
    assert track.pose.distance_to(off) < 0.003


def test_to_look_how_it_fits_moves_nothing() -> None:
    track = track_at(TRUE @ Pose2(0.004, 0, 0))
    before = track.pose
    track.fit(RAYS, SETUP)
    assert track.pose == before and track.log_weight == 0


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (Pose2(0.02, 0.02, 3.15), True),
        (Pose2(0.031, 0.0, 3.1), False),
        (Pose2(0.0, 0.0, 3.21), False),
        (Pose2(0.0, 0.0, -3.1), True),
    ],
    ids=str,
)
def test_places_near_each_other_and_alike_in_heading_are_one(other: Pose2, same: bool) -> None:
    here, parameters = Pose2(0, 0, 3.1), HypothesisParameters(same_xy=0.03, same_theta=0.1)
    assert parameters.alike(here, other) == parameters.alike(other, here) == same


def test_probabilities_are_given_as_logarithms_also_of_nothing() -> None:
    one = HypothesisParameters(kidnapped=1e-3, hopeless=1e-2)
    assert np.exp([one.log_kidnapped, one.log_hopeless]) == pytest.approx([1e-3, 1e-2])
    assert np.isfinite(replace(one, hopeless=0.0).log_hopeless)


def test_no_single_thing_outweighs_a_confirmed_place() -> None:
    tracks = track_at(TRUE), track_at(TRUE)
    tracks[0].confirmed = True
    for _ in range(30):  # A second of scans that fit another place better.
        for track in tracks:
            track.lose(3.0, 3.0)
    confirmed, other = (track.log_weight for track in tracks)
    assert other < -80
    assert DEFAULTS.hypotheses.log_kidnapped < confirmed < -ONE_THING


def test_a_confirmed_place_that_fits_worse_all_the_time_is_given_up() -> None:
    track = track_at(TRUE)
    track.confirmed = True
    for _ in range(120):
        track.lose(1.0, 3.0)
    assert track.log_weight < DEFAULTS.hypotheses.log_hopeless
