"""Many places are followed at once, until a mark tells them apart; and it knows when it is lost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from square_drive import NARROW, ON_SQUARE, ON_STUB, SQUARE, drive_on, right, setup_of
from stub_drive import (
    BEARINGS,
    DEFAULTS,
    STUB,
    Drive,
    check_sound,
    near,
)

from robot.geometry import Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Setup
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.localizer import make_filter
from robot.scan import Scan

WIDE = np.diag(np.square([0.1, 0.1, 0.3]))
CLAIM = 0.95
"""A weight that is taken for certainty."""


def filter_of(setup: Setup = ON_STUB, seed: int = 0) -> MultiHypothesisFilter:
    made = make_filter(setup, np.random.default_rng(seed))
    assert isinstance(made, MultiHypothesisFilter)
    return made


def scattered(setup: Setup = ON_STUB, seed: int = 0) -> MultiHypothesisFilter:
    f = filter_of(setup, seed)
    f.scatter()
    return f


def follow(f: MultiHypothesisFilter, drive: Drive, seconds: float) -> Iterator[list[Hypothesis]]:
    """The hypotheses after each scan."""
    for moved, scan in drive.eight(seconds):
        f.predict(moved)
        f.correct(scan)
        yield list(f.hypotheses)


def run(f: MultiHypothesisFilter, drive: Drive, seconds: float) -> list[Hypothesis]:
    return list(follow(f, drive, seconds))[-1]


def total(found: list[Hypothesis]) -> float:
    return sum(one.weight for one in found)


# --- all over the field


def test_scattered_it_says_nothing_at_first_and_shows_all_of_the_field() -> None:
    f, drive = scattered(), Drive(Pose2(-0.1, 0.05, 2.2))
    assert all(not found for found in follow(f, drive, 0.2))
    assert f.hypotheses == ()
    spread = f.cloud.poses.std(axis=0)
    assert (spread > [0.2, 0.2, 1.5]).all()
    assert f.effective == pytest.approx(len(f.cloud.poses))


@pytest.mark.parametrize("seed", range(3))
def test_on_a_plain_square_it_follows_all_four_places_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = Pose2.from_array(rng.uniform([-0.15, -0.15, -3], [0.15, 0.15, 3]))
    f, drive = scattered(ON_SQUARE, seed), drive_on(SQUARE, start, seed)
    for found in follow(f, drive, 6.0):
        assert total(found) <= 1 + 1e-9
        if drive.stamp < 3:
            continue
        for quarter in range(4):
            place = Pose2(0, 0, quarter * math.pi / 2) @ drive.true
            (there,) = [one for one in found if near(one.pose, place, 0.01, 0.03)]
            assert 0.15 < there.weight < 0.3
    check_sound(f)


STARTS = [
    Pose2(-0.13, 0.05, 2.2),
    Pose2(-0.1, -0.09, 2.4),
    Pose2(-0.05, 0.04, -2.5),
    Pose2(-0.16, -0.06, -3.1),
]
"""From these the robot looks away from the stub at first, and sees it within 6 s."""


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "start"), list(enumerate(STARTS)))
def test_it_is_sure_only_once_the_stub_tells_and_then_right(seed: int, start: Pose2) -> None:
    f, drive = scattered(seed=seed), drive_on(STUB, start, seed)
    claims = [
        (drive.stamp, right(found[0], drive))
        for found in follow(f, drive, 6.5)
        if found and found[0].weight > CLAIM
    ]
    assert claims, "it makes up its mind"
    assert claims[0][0] > 1.5, "not before there is anything to tell by"
    assert all(true for _, true in claims)
    assert right(f.hypotheses[0], drive) and f.hypotheses[0].weight > CLAIM
    check_sound(f)


def test_places_that_cannot_be_told_apart_yet_weigh_about_the_same() -> None:
    f, drive = scattered(), drive_on(STUB, STARTS[1])
    found = run(f, drive, 2.0)
    alike = [one.weight for one in found if one.weight > 0.05]
    assert len(alike) >= 2 and max(alike) < 1.2 * min(alike)


def test_where_too_few_rays_return_it_does_not_search() -> None:
    f, drive = scattered(), Drive()
    for moved, scan in drive.eight(2.0):
        ranges = np.where(np.arange(61) < 30, scan.ranges, np.inf)
        f.predict(moved)
        f.correct(Scan(scan.stamp, BEARINGS, ranges))
        assert f.hypotheses == ()
    assert run(f, drive, 2.0), "it does when it sees again"


# --- told a pose


@pytest.mark.parametrize("seed", range(4))
def test_told_a_pose_it_stays_sure_of_it(seed: int) -> None:
    """No false alarm: what is missing of the weights stays small."""
    f, drive = filter_of(seed=seed), drive_on(STUB, Pose2(), seed)
    f.set_pose(drive.true, NARROW)
    for found in follow(f, drive, 5.0):
        assert right(found[0], drive) and found[0].weight > 0.9
        assert total(found) > CLAIM


@pytest.mark.parametrize(("seed", "start"), list(enumerate([Pose2(), *STARTS[:3]])))
def test_a_pose_told_wrong_within_what_was_told_is_mended(seed: int, start: Pose2) -> None:
    f, drive = filter_of(seed=seed), drive_on(STUB, start, seed)
    f.set_pose(drive.true @ Pose2(0.06, -0.08, 0.3), WIDE)
    found = run(f, drive, 1.0)
    assert right(found[0], drive) and found[0].weight > 0.9


def test_what_was_told_counts_where_scans_cannot_tell() -> None:
    """On a square three other places fit as well; that the robot was told to be here decides."""
    f, drive = filter_of(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    f.set_pose(drive.true, NARROW)
    for found in follow(f, drive, 6.0):
        assert right(found[0], drive) and found[0].weight > 0.9


def test_a_pose_told_quite_wrong_is_given_up() -> None:
    """Told to be sure of a place half a metre off, which looks otherwise."""
    f, drive = filter_of(), drive_on(STUB, Pose2(-0.2, -0.1, 0.1))
    f.set_pose(Pose2(0.25, 0.3, -2.5), NARROW)
    found = run(f, drive, 0.4)
    assert sum(one.weight for one in found if not right(one, drive)) < 0.5
    found = run(f, drive, 2.0)
    assert right(found[0], drive) and found[0].weight > 0.9


def test_a_pose_told_anew_ends_all_other_hypotheses() -> None:
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2())
    assert len(run(f, drive, 2.0)) >= 4
    f.set_pose(Pose2(0.1, 0.1, 1.0), NARROW)
    (one,) = f.hypotheses
    assert near(one.pose, Pose2(0.1, 0.1, 1.0), 0.002, 0.005) and one.weight > 0.99


# --- carried elsewhere


AWAY = [
    Pose2(-0.25, 0.2, -2.0),
    Pose2(0.05, -0.2, 0.3),
    Pose2(-0.2, -0.1, 0.1),
    Pose2(0.25, 0.3, -2.5),
]
"""From these the stub comes into sight within 2 s."""


@pytest.mark.parametrize(("seed", "there"), list(enumerate(AWAY)))
def test_carried_elsewhere_it_knows_that_it_is_lost_and_finds_itself(
    seed: int, there: Pose2
) -> None:
    f, drive = filter_of(seed=seed), drive_on(STUB, Pose2(), seed)
    f.set_pose(drive.true, NARROW)
    assert total(run(f, drive, 1.0)) > CLAIM
    drive.true = there
    for found in follow(f, drive, 0.4):
        wrong = sum(one.weight for one in found if not right(one, drive))
    assert wrong < 0.5, "soon it does not believe that it is where it was"
    found = run(f, drive, 0.4)
    assert any(right(one, drive) for one in found), "lost, it looks for places at once"
    for found in follow(f, drive, 2.2):
        if found[0].weight > CLAIM:
            assert right(found[0], drive)
    assert right(f.hypotheses[0], drive) and f.hypotheses[0].weight > 0.9
    check_sound(f)


def test_carried_on_a_square_it_finds_all_four_places_again() -> None:
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    run(f, drive, 2.0)
    drive.true = Pose2(-0.2, -0.1, -0.4)
    found = run(f, drive, 3.0)
    for quarter in range(4):
        place = Pose2(0, 0, quarter * math.pi / 2) @ drive.true
        (there,) = [one for one in found if near(one.pose, place, 0.01, 0.03)]
        assert 0.1 < there.weight < 0.4


# --- it stays as it is


def test_standing_still_tells_nothing_new() -> None:
    """However often the same is seen, the weights stay."""
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    run(f, drive, 3.0)
    for _ in range(12):
        f.correct(drive.scan())
    before = f.hypotheses
    for _ in range(60):
        f.predict(Pose2())
        f.correct(drive.scan())
    after = f.hypotheses
    assert [one.weight for one in after] == pytest.approx([one.weight for one in before])
    for one in before:
        assert any(near(one.pose, other.pose, 0.001, 0.003) for other in after)


def test_blind_it_keeps_its_places_and_follows_odometry() -> None:
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    before = run(f, drive, 3.0)
    for _ in range(30):
        f.predict(Pose2(0.002, 0, 0.01))
        f.correct(Scan(0.0, BEARINGS[:0], np.zeros(0)))
    step = Pose2()
    for _ in range(30):
        step = step @ Pose2(0.002, 0, 0.01)
    for one in before:
        if one.weight > 0.1:
            there = one.pose @ step
            assert any(near(other.pose, there, 0.01, 0.05) for other in f.hypotheses)
    check_sound(f)


def test_the_same_seed_gives_the_same_bit_for_bit() -> None:
    def told(seed: int) -> list[tuple[float, ...]]:
        f, drive = scattered(seed=seed), drive_on(STUB, STARTS[2])
        return [
            (one.weight, one.pose.x, one.pose.y, one.pose.theta)
            for found in follow(f, drive, 1.6)
            for one in found
        ]

    assert told(5) == told(5) != told(6)


def test_other_parameters_count_at_once_and_the_places_stay() -> None:
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    before = run(f, drive, 3.0)
    small = replace(DEFAULTS.filter, min_particles=40, max_particles=50)
    f.use(replace(ON_SQUARE, parameters=replace(DEFAULTS, filter=small)))
    assert [(one.weight, one.pose) for one in f.hypotheses] == [
        (one.weight, one.pose) for one in before
    ]
    found = run(f, drive, 0.5)
    assert len([one for one in found if one.weight > 0.1]) == 4
    assert len(f.cloud.poses) <= 50 * len(found)
    one_only = replace(DEFAULTS, hypotheses=replace(DEFAULTS.hypotheses, max_hypotheses=1))
    f.use(replace(ON_SQUARE, parameters=one_only))
    assert len(run(f, drive, 0.5)) == 1


def test_all_places_move_with_odometry() -> None:
    f, drive = scattered(ON_SQUARE), drive_on(SQUARE, Pose2(0.05, 0.1, 0.5))
    before = [one.pose for one in run(f, drive, 3.0)]
    f.predict(Pose2(0.05, 0.01, 0.2))
    for pose in before:
        there = pose @ Pose2(0.05, 0.01, 0.2)
        assert any(near(one.pose, there, 0.003, 0.02) for one in f.hypotheses)


def test_searches_never_bring_more_than_may_be_followed() -> None:
    f = scattered(setup_of(SQUARE, ON_SQUARE.entries, max_hypotheses=3))
    counts = [len(found) for found in follow(f, drive_on(SQUARE, Pose2()), 3.0)]
    assert max(counts) == 3
