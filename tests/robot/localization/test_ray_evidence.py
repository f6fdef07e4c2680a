"""Rays weigh places: what is seen tells, and what is not seen but should be tells as well."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stub_drive import MAPS, STUB, Drive

from robot import ray_columns as column
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.localization.ray_evidence import (
    END,
    FAR,
    MISSED,
    NEAR,
    SEEN,
    STRAY,
    THING,
    UNEXPECTED_SHARE,
    RayEvidence,
)
from robot.scan import rays_of

SQUARE, TOWN = load_field("square", MAPS), load_field("town", MAPS)
SD = 0.01
SCANNED = {of.name: RayEvidence.of(of, 1.0, SD) for of in (STUB, SQUARE, TOWN)}
ON = {name: one._replace(sight=one.sight._replace(support=0.0)) for name, one in SCANNED.items()}
"""Of these a single ray can miss an edge."""
BEST = math.log(SEEN / (SD * math.sqrt(2 * math.pi)) + STRAY)
"""Of a ray that ends just where it should."""
AT_SIDE = Pose2(-0.1, -0.025, math.pi / 2)
"""Half a metre ahead lies a long edge, and no other."""
ACROSS_STUB = Pose2(0.3, 0.2, -math.pi / 2)
"""0.175 m ahead lies the stub, far from its end; 0.675 m ahead the side behind it."""
ACROSS_END = Pose2(0.2, 0.2, -math.pi / 2)
"""As before, but 25 mm from the stub's end."""


def ray(
    length: float,
    near: float = 0.0,
    far: float = math.inf,
    bearing: float = 0.0,
    clear: float = 1.0,
    thing: tuple[float, float] = (math.inf, -math.inf),
) -> Array:
    return np.array([[0.0, 0.0, bearing, length, near, far, clear, *thing]])


def value(pose: Pose2, rays: Array, on: str = "stub") -> float:
    return ON[on].log_likelihood(pose, rays)


def seen_from(true: Pose2, of: Field = STUB, robot_from_scan: Pose2 = Pose2()) -> Array:
    return rays_of(Drive(true, edges_of=of, robot_from_scan=robot_from_scan).scan(), 99)


# --- one ray


@pytest.mark.parametrize(
    ("pose", "length", "wanted"),
    [
        (AT_SIDE, 0.5, BEST),
        (AT_SIDE, 0.51, math.log(SEEN / (SD * math.sqrt(2 * math.pi)) * math.exp(-0.5) + STRAY)),
        (AT_SIDE, 0.3, math.log(STRAY)),
        (AT_SIDE, math.inf, math.log(MISSED)),
        (Pose2(0.7, 0.7, 0.8), 0.3, math.log(UNEXPECTED_SHARE)),
        (Pose2(0.7, 0.7, 0.8), math.inf, 0.0),
    ],
    ids=["as due", "one sd off", "stray", "missed", "surprise", "nothing, as due"],
)
def test_a_ray_counts_as_the_mixture_says(pose: Pose2, length: float, wanted: float) -> None:
    assert value(pose, ray(length)) == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize(
    ("pose", "thing", "wanted"),
    [
        (AT_SIDE, (0.4, 0.7), math.log(THING)),  # on the edge
        (AT_SIDE, (0.0, 0.7), math.log(THING)),  # from the ray's start on
        (AT_SIDE, (0.3, math.inf), math.log(THING)),
        (AT_SIDE, (0.2, 0.3), math.log(THING) + math.log(MISSED)),  # in front: the edge is seen
        (Pose2(0.7, 0.7, 0.8), (0.2, 0.3), math.log(THING)),
        (AT_SIDE, (0.49, 0.56), math.log(MISSED)),  # the tape itself, not recognized
        (AT_SIDE, (0.51, math.inf), math.log(MISSED)),
    ],
)
def test_what_lies_on_the_floor_hides_edges_at_a_price(
    pose: Pose2, thing: tuple[float, float], wanted: float
) -> None:
    """A shoe hides tape; tape that is drawn there is no shoe."""
    assert value(pose, ray(math.inf, thing=thing)) == pytest.approx(wanted)


def test_an_edge_behind_a_thing_may_be_returned() -> None:
    wanted = BEST + math.log(THING)
    assert value(ACROSS_STUB, ray(0.675, thing=(0.1, 0.3))) == pytest.approx(wanted)
    assert value(ACROSS_STUB, ray(0.675)) < wanted - 2
    assert value(ACROSS_STUB, ray(0.675, thing=(0.3, 0.5))) < wanted - 2


def test_things_weigh_as_much_where_nothing_fits() -> None:
    """So a floor full of shoes does not tell that the robot is elsewhere."""
    seen, blocked = ray(0.5), ray(0.5, thing=(0.1, 0.2))
    for rays in (seen, ray(math.inf)):
        other = rays.copy()
        other[:, 7:] = blocked[:, 7:]
        before, after = (ON["stub"].background_log_likelihood(each) for each in (rays, other))
        assert after - before == pytest.approx(math.log(THING))


@pytest.mark.parametrize("within", [0.0, 0.3, math.inf])
@pytest.mark.parametrize("name", ["stub", "square", "town"])
def test_only_a_pose_that_cannot_win_is_not_weighed_to_the_end(name: str, within: float) -> None:
    """And whatever the order of the poses: those that are near the best have all their digits."""
    rng = np.random.default_rng(1)
    evidence, of = SCANNED[name], {"stub": STUB, "square": SQUARE, "town": TOWN}[name]
    true = of.start
    rays = seen_from(true, of)
    poses = true.to_array() + rng.normal(0, [0.02, 0.02, 0.1], (200, 3))
    alone = np.array([evidence.log_likelihoods(pose[None], rays)[0] for pose in poses])
    logs = evidence.log_likelihoods(poses, rays, within=within)
    ended = np.isinf(logs)
    assert logs.max() == alone.max()
    np.testing.assert_array_equal(logs[~ended], alone[~ended])
    best = np.maximum.accumulate(alone)
    assert (alone[ended] < best[ended] - within).all()
    assert ended.any() == (within < math.inf)


def test_returns_count_alike_however_far_rays_reach() -> None:
    """What is from anywhere may be anywhere along the ray."""
    far = RayEvidence.of(STUB, 4.0, SD)
    assert far.log_likelihood(AT_SIDE, ray(0.3)) == pytest.approx(math.log(STRAY / 4))
    assert far.log_likelihood(Pose2(0.7, 0.7, 0.8), ray(0.3)) == pytest.approx(
        math.log(UNEXPECTED_SHARE / 4)
    )


@pytest.mark.parametrize(
    ("near", "far", "counts"),
    [
        (0.0, math.inf, True),
        (0.0, 0.4, False),
        (0.0, 0.5 + 0.9 * FAR, False),
        (0.0, 0.5 + 1.1 * FAR, True),
        (0.6, 0.9, False),
        (0.5 - 0.9 * NEAR, 0.9, False),
        (0.5 - 1.1 * NEAR, 0.9, True),
    ],
)
def test_only_an_edge_well_in_sight_can_be_missed(near: float, far: float, counts: bool) -> None:
    missed = value(AT_SIDE, ray(math.inf, near, far))
    assert missed == pytest.approx(math.log(MISSED) if counts else 0)


def test_tape_met_aslant_must_lie_farther_in_sight() -> None:
    """All of its width is seen only then."""
    pose, due = Pose2(0.1, 0.3, math.pi / 2 + math.pi / 3), 0.35
    assert value(pose, ray(due)) == pytest.approx(BEST)
    assert value(pose, ray(math.inf, 0, due + 1.9 * FAR)) == 0
    assert value(pose, ray(math.inf, 0, due + 2.1 * FAR)) == pytest.approx(math.log(MISSED))


def test_an_edge_that_too_few_rays_meet_may_be_missed() -> None:
    """Tape in the corner of a picture: the scanner needs 40 mm of it on neighbouring rays."""
    fan = np.radians([0.0, 3.0, 6.0, 9.0])
    rays = np.vstack([ray(math.inf, far=1.0, bearing=bearing) for bearing in fan])
    # Half a metre away they meet the edge 26 mm apart.
    for count, counts in ((1, False), (2, False), (3, True), (4, True)):
        assert (SCANNED["stub"].log_likelihood(AT_SIDE, rays[:count]) < 0) == counts
    apart = rays[[0, 2]]
    assert SCANNED["stub"].log_likelihood(AT_SIDE, apart) < 0
    # The second leaves the picture before it is through the tape.
    apart[1, 5] = 0.52
    assert SCANNED["stub"].log_likelihood(AT_SIDE, apart) == 0


def test_an_edge_before_sight_begins_does_not_hide_what_is_behind_it() -> None:
    assert value(ACROSS_STUB, ray(0.675)) == pytest.approx(math.log(STRAY), abs=1e-6)
    assert value(ACROSS_STUB, ray(0.675, near=0.25)) == pytest.approx(BEST, abs=1e-6)


def test_tape_close_to_its_end_may_be_missed_or_seen_past() -> None:
    assert value(ACROSS_END, ray(math.inf)) == 0
    assert value(ACROSS_END, ray(0.175)) == pytest.approx(BEST)
    assert value(ACROSS_END, ray(0.675)) == pytest.approx(BEST)
    assert value(ACROSS_END, ray(0.4)) == pytest.approx(math.log(STRAY), abs=1e-6)
    assert value(ACROSS_STUB, ray(math.inf)) == pytest.approx(math.log(MISSED))
    assert value(ACROSS_STUB, ray(0.675)) == pytest.approx(math.log(STRAY), abs=1e-6)


@pytest.mark.parametrize(("from_end", "lenient"), [(0.9 * END, True), (1.1 * END, False)])
@pytest.mark.parametrize("end", ["start", "end"])
def test_both_ends_of_tape_are_lenient(end: str, from_end: float, lenient: bool) -> None:
    """The stub's upper edge begins at the side and ends inside; its lower the other way."""
    upward = -1 if end == "start" else 1
    pose = Pose2(0.175 + from_end, upward * 0.2, -upward * math.pi / 2)
    assert (value(pose, ray(math.inf)) == 0) == lenient


@pytest.mark.parametrize("clear", [1.0, 0.6, 0.0])
def test_a_ray_of_a_picture_that_is_not_clear_tells_less(clear: float) -> None:
    missed = MISSED + SEEN * (1 - clear) * (1 - MISSED)
    assert value(AT_SIDE, ray(math.inf, clear=clear)) == pytest.approx(math.log(missed))
    peak = clear * SEEN / (SD * math.sqrt(2 * math.pi))
    assert value(AT_SIDE, ray(0.5, clear=clear)) == pytest.approx(math.log(peak + STRAY))


def test_a_far_range_errs_more_by_the_slope() -> None:
    sloping = RayEvidence.of(STUB, 1.0, SD, slope=12.0)
    wide = SD * (1 + 12.0 * 0.5**2)
    peak = SEEN / (wide * math.sqrt(2 * math.pi))
    assert sloping.log_likelihood(AT_SIDE, ray(0.5)) == pytest.approx(math.log(peak + STRAY))
    off = 0.5 + wide * math.sqrt(2)
    wanted = math.log(peak / math.e + STRAY)
    # Which spread a ray has is told by its own range.
    assert sloping.log_likelihood(AT_SIDE, ray(off)) == pytest.approx(wanted, abs=0.15)
    np.testing.assert_allclose(sloping.log_peaks(np.array([0.5])), [math.log(peak + STRAY)])


def test_what_is_blind_may_be_missed_or_seen_past() -> None:
    blind = ON["stub"].sight._replace(seen=np.zeros_like(ON["stub"].sight.seen))
    one = ON["stub"]._replace(sight=blind)
    for pose in (AT_SIDE, ACROSS_STUB):
        assert one.log_likelihood(pose, ray(math.inf)) == 0
    assert one.log_likelihood(AT_SIDE, ray(0.5)) == pytest.approx(BEST)
    assert one.log_likelihood(ACROSS_STUB, ray(0.675)) == pytest.approx(BEST, abs=1e-6)


# --- many rays


def test_no_rays_tell_nothing() -> None:
    assert value(AT_SIDE, np.zeros((0, 9))) == 0


def test_it_is_the_average_of_the_rays() -> None:
    rays = seen_from(Pose2(0.05, 0.02, 0.1))
    pose = Pose2(0.06, 0.03, 0.2)
    each = [value(pose, rays[i : i + 1]) for i in range(len(rays))]
    assert np.ptp(each) > 1
    assert value(pose, rays) == pytest.approx(np.mean(each))


def test_rays_that_start_elsewhere_than_the_robot_fit_at_the_truth() -> None:
    true, offset = Pose2(0.05, 0.1, -0.3), Pose2(0.06, -0.04, 0.5)
    rays = seen_from(true, robot_from_scan=offset)
    assert value(true, rays) > value(true @ offset, rays) + 1
    assert value(true, rays) == pytest.approx(
        value(true @ offset, seen_from(true @ offset)), abs=0.01
    )


@settings(max_examples=40)
@given(st.sampled_from([STUB, SQUARE, TOWN]), st.integers(0, 10_000))
def test_no_place_fits_better_than_the_truth(of: Field, seed: int) -> None:
    poses = of.free_poses(np.random.default_rng(seed), 60)
    true = Pose2.from_array(poses[0])
    rays = seen_from(true, of)
    others = np.array([value(Pose2.from_array(pose), rays, of.name) for pose in poses[1:]])
    assert others.max() <= value(true, rays, of.name) + 0.02
    if np.isfinite(rays[:, column.RANGE]).mean() > 0.5:
        assert np.median(others) < value(true, rays, of.name) - 1


BEFORE_STUB = Pose2(0.1, 0.25, -0.9)
TURNED = Pose2(0, 0, math.pi) @ BEFORE_STUB
"""A place that would look the same but for the stub."""


def test_a_mark_that_should_be_seen_and_is_not_tells_against_a_place() -> None:
    rays = seen_from(TURNED)
    assert value(TURNED, rays) > value(BEFORE_STUB, rays) + 0.3


def test_that_also_nothing_is_seen_where_a_mark_is_due_tells_against_a_place() -> None:
    short = RayEvidence.of(STUB, 0.45, SD)
    rays, due = seen_from(TURNED), seen_from(BEFORE_STUB)[:, 3]
    nothing = rays[(rays[:, column.RANGE] > 0.45) & (due < 0.38)]
    nothing[:, 3] = np.inf
    assert len(nothing) > 5
    assert short.log_likelihood(TURNED, nothing) == 0
    assert short.log_likelihood(BEFORE_STUB, nothing) < 0.5 * math.log(MISSED)


def test_a_mark_that_is_seen_and_not_in_the_map_tells_against_it() -> None:
    with_stub, without = seen_from(BEFORE_STUB), seen_from(BEFORE_STUB, SQUARE)
    assert value(BEFORE_STUB, without, "square") > value(BEFORE_STUB, with_stub, "square") + 0.3
