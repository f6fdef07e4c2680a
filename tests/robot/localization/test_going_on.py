"""A filter begins at several places, or goes on from what another one believes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from square_drive import ON_STUB
from stub_drive import Drive, check_sound, follow, near

from robot.geometry import Pose2, mean_pose, pose_covariance
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Filter
from robot.localization.filter_kinds import FILTERS
from robot.localization.localizer import transfer_belief

HERE, THERE = Pose2(0.2, 0.1, 0.5), Pose2(-0.2, -0.1, 0.7)
WIDE = np.diag(np.square([0.1, 0.08, 0.2]))


def made(name: str, seed: int = 0) -> Filter:
    return FILTERS[name].make(ON_STUB, np.random.default_rng(seed))


@pytest.mark.parametrize("name", FILTERS)
def test_told_several_places_its_cloud_is_a_mixture_of_them(name: str) -> None:
    f = made(name)
    f.set_hypotheses((Hypothesis(1.0, THERE, WIDE), Hypothesis(3.0, HERE, WIDE)))
    check_sound(f)
    cloud = f.cloud
    mean = mean_pose(cloud.poses, cloud.weights)
    assert near(mean, Pose2(0.1, 0.05, 0.55), 0.02, 0.03)
    between = 0.75 * 0.25 * np.square([0.4, 0.2, 0.2])
    spread = np.diag(pose_covariance(cloud.poses, cloud.weights, mean))
    np.testing.assert_allclose(spread, np.diag(WIDE) + between, rtol=0.15)


def test_wide_places_are_followed_as_they_were_told_and_not_in_pieces() -> None:
    f = made("hypotheses")
    f.set_hypotheses((Hypothesis(1.0, THERE, WIDE), Hypothesis(3.0, HERE, WIDE)))
    by_place = [sum(h.weight for h in f.hypotheses if h.pose.x * side > 0) for side in (1, -1)]
    assert by_place == pytest.approx([0.75, 0.25], abs=0.03)
    assert near(f.hypotheses[0].pose, HERE, 0.03, 0.05)


@pytest.mark.parametrize(
    ("before", "after"),
    [pair for pair in itertools.product(FILTERS, FILTERS) if pair[0] != pair[1]],
)
def test_another_filter_goes_on_at_the_place_where_one_was(before: str, after: str) -> None:
    old, drive = made(before), Drive(Pose2(0.1, 0.1, 0.3))
    old.set_pose(drive.true, np.diag(np.square([0.02, 0.02, 0.05])))
    for _ in follow(old, drive, 0.5):
        pass
    new = transfer_belief(made(after, seed=1), old)
    check_sound(new)
    assert near(new.hypotheses[0].pose, drive.true, 0.01, 0.02)
    assert new.hypotheses[0].weight > 0.9
    assert max(follow(new, drive, 0.5)) < 0.01


@pytest.mark.parametrize("after", FILTERS)
def test_another_filter_is_as_unsure_as_the_one_before(after: str) -> None:
    old = made("kalman")
    old.set_pose(HERE, WIDE)
    cloud = transfer_belief(made(after, seed=1), old).cloud
    mean = mean_pose(cloud.poses, cloud.weights)
    assert near(mean, HERE, 0.02, 0.03)
    spread = np.sqrt(np.diag(pose_covariance(cloud.poses, cloud.weights, mean)))
    np.testing.assert_allclose(spread, np.sqrt(np.diag(WIDE)), rtol=0.15)
