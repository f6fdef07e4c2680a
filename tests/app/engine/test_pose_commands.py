"""Beliefs told by commands: what is one and what is not; and what the wire says of beliefs."""

import base64

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from app.engine.pose_commands import cloud_of, covariance_of
from app.messages.commands import MOST_POSES, SetParticlesCommand, SetPoseCommand
from app.page.belief import MOST_PARTICLES, alike, integrity_message, packed
from robot.errors import CommandError
from robot.localization.estimate import Alert, Cause, Integrity, State
from robot.localization.filter import Cloud
from robot.localization.parameters import FilterParameters


def told(**more):
    return SetPoseCommand(type="set_pose", x=0, y=0, theta=0, **more)


def some(poses, weights=None):
    return SetParticlesCommand(type="set_particles", poses=poses, weights=weights)


def test_a_pose_is_told_with_a_covariance_or_with_deviations_but_not_both():
    usual = FilterParameters(initial_sd_xy=0.5, initial_sd_theta=0.2)
    np.testing.assert_array_equal(
        covariance_of(told(sd_xy=0.1), usual), np.diag(np.square([0.1, 0.1, 0.2]))
    )
    with pytest.raises(CommandError, match="either"):
        covariance_of(told(sd_theta=0.1, covariance=[1.0, 0, 0, 0, 1, 0, 0, 0, 1]), usual)


@given(st.lists(st.floats(0, 1e308), min_size=1, max_size=20).filter(lambda w: max(w) > 1e-300))
def test_weights_are_normalized_whatever_their_measure(weights):
    cloud = cloud_of(some([(0.1, 0.2, 0.3)] * len(weights), weights))
    assert cloud.weights.sum() == pytest.approx(1)
    assert (cloud.weights >= 0).all()


def test_without_weights_all_poses_are_alike_and_headings_are_wrapped():
    cloud = cloud_of(some([(0, 0, 7.0), (1, 1, -7.0)]))
    assert cloud.weights.tolist() == [0.5, 0.5]
    assert cloud.poses[:, 2] == pytest.approx([7 - 2 * np.pi, 2 * np.pi - 7])


@pytest.mark.parametrize(
    ("weights", "why"),
    [([0.0, 0.0], "all weights are zero"), ([1.0], "1 weights for 2 poses"), ([], "0 weights")],
)
def test_weights_that_say_nothing_are_refused(weights, why):
    with pytest.raises(CommandError, match=why):
        cloud_of(some([(0, 0, 0), (1, 1, 1)], weights))


@pytest.mark.parametrize(
    "wrong",
    [
        {"poses": []},
        {"poses": [(0, 0, 0)] * (MOST_POSES + 1)},
        {"poses": [(0, 0)]},
        {"poses": [(0, 0, float("nan"))]},
        {"poses": [(0, 0, 0)], "weights": [-1.0]},
        {"poses": [(0, 0, 0)], "weights": [float("inf")]},
    ],
)
def test_poses_that_are_none_are_refused(wrong):
    with pytest.raises(ValidationError):
        SetParticlesCommand(type="set_particles", **wrong)


def test_an_infinite_bound_is_null_and_reasons_are_told_in_their_words():
    nothing = integrity_message(Integrity(State.SEARCHING))
    assert nothing.model_dump(mode="json") == {
        "state": "searching",
        "radius": None,
        "heading_bound": None,
        "alerts": [],
    }
    late = Alert(Cause.PICTURES_LATE, "pictures seem to come 30 ms late")
    message = integrity_message(Integrity(State.APPROXIMATE, 0.06, 0.2, (late,)))
    assert (message.radius, message.heading_bound) == (0.06, 0.2)
    assert message.alerts == ["pictures seem to come 30 ms late"]


@pytest.mark.parametrize(
    ("state", "count"),
    [("searching", 0), ("lost", 0), ("certain", 1), ("approximate", 1), ("ambiguous", 2)],
)
def test_places_are_counted_that_weigh_half_as_much_as_the_heaviest(state, count):
    assert alike(State(state), (0.4, 0.2, 0.19)) == count


@pytest.mark.parametrize("count", [MOST_PARTICLES, MOST_PARTICLES + 1, 2 * MOST_PARTICLES - 1])
def test_no_more_particles_are_sent_than_a_map_shows(count):
    sent = base64.b64decode(packed(Cloud.even(np.zeros((count, 3))), (-1.0, -1.0, 1.0, 1.0)))
    assert MOST_PARTICLES / 2 <= len(sent) / 8 <= MOST_PARTICLES


def test_an_empty_cloud_and_one_without_weight_can_be_sent():
    extent = (-1.0, -1.0, 1.0, 1.0)
    assert packed(Cloud(np.empty((0, 3)), np.empty(0)), extent) == ""
    one = base64.b64decode(packed(Cloud(np.zeros((1, 3)), np.zeros(1)), extent))
    assert len(one) == 8
    assert one[6] == 0
