"""The short map holds the scans of the last moments, as odometry lays them together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stub_drive import BEARINGS, DEFAULTS, PERIOD, STUB, Drive

from robot import ray_columns as column
from robot.fields.edges import sample
from robot.geometry import Array, Pose2, Twist2
from robot.localization.hypotheses.local_map import LocalMap
from robot.scan import Scan, rays_of

MOTION = DEFAULTS.motion.model()


def blank(stamp: float = 0.0, hits: int = 61) -> Scan:
    ranges = np.full(61, np.inf)
    ranges[:hits] = 0.3
    return Scan(stamp, BEARINGS, ranges)


def driven(steps: list[Pose2], most: int = 24) -> LocalMap:
    """Scans numbered by their stamps, each after its step; all are kept."""
    local = LocalMap(0.0, 0.0, most)
    for number, step in enumerate(steps):
        local.move(step)
        assert local.add(blank(float(number)))
    return local


# --- which scans it keeps


def test_a_scan_is_kept_after_enough_way_or_turn_since_the_last_kept() -> None:
    local = LocalMap(0.01, 0.05, 24)
    assert local.add(blank())
    for step, kept in [
        (Pose2(), False),
        (Pose2(0.006), False),
        (Pose2(0.006), True),
        (Pose2(0.003, 0.0099), True),
        (Pose2(-0.009), False),
        (Pose2(-0.002), True),
        (Pose2(0, 0, 0.03), False),
        (Pose2(0, 0, 0.03), True),
        (Pose2(0, 0, -0.051), True),
        (Pose2(0, 0, 0.06), True),
        (Pose2(0, 0, -0.04), False),
    ]:
        local.move(step)
        assert local.add(blank()) == kept
    assert len(local) == 7


def test_of_more_than_it_may_hold_the_newest_stay() -> None:
    local = driven([Pose2(0.01)] * 9, most=4)
    assert len(local) == 4
    past = local.past(4, 61, MOTION)
    assert len(past.moves) == 4
    np.testing.assert_allclose(past.moves[1:, 0], -0.01)


@given(st.integers(1, 12), st.integers(0, 15))
def test_it_forgets_all_but_the_newest(count: int, but: int) -> None:
    local = driven([Pose2(0.01 * (i + 1)) for i in range(count)])
    local.begin_anew(but)
    assert len(local) == min(count, but)
    if len(local) > 1:
        newest = local.past(99, 5, MOTION).moves[1:, 0]
        steps = 0.01 * np.arange(count, 1, -1)
        np.testing.assert_allclose(newest, -steps[: len(newest)])


def test_it_tells_how_the_robot_moved_since_the_newest_scan() -> None:
    local = driven([Pose2(0.1, 0.2, 2.0), Pose2(0.3, 0, 2.0)])
    assert local.since == Pose2()
    local.move(Pose2(0.02, 0.01, 0.4))
    local.move(Pose2(0.03, 0, -0.1))
    wanted = Pose2(0.02, 0.01, 0.4) @ Pose2(0.03, 0, -0.1)
    np.testing.assert_allclose(local.since.to_array(), wanted.to_array(), atol=1e-12)


def test_hits_count_over_all_scans_that_are_kept() -> None:
    local = LocalMap(0.0, 0.0, 3)
    shares = []
    for hits in (61, 0, 61, 0, 0):
        local.add(blank(hits=hits))
        shares.append(local.hit_share)
    assert shares == pytest.approx([1, 1 / 2, 2 / 3, 1 / 3, 1 / 3])


# --- how they are laid together


def stretch(scale: float) -> tuple[LocalMap, Drive]:
    """A second of a drive, by odometry that is exact times a scale."""
    local, drive = (
        LocalMap(0.0, 0.0, 99),
        Drive(Pose2(0.1, 0.2, 2.0), robot_from_scan=Pose2(0.04, 0.02, 0.3)),
    )
    for _ in range(30):
        drive.step(Twist2(0.15, 1.5))
        local.move(Twist2(0.15, 1.5 * scale).integrate(PERIOD))
        local.add(drive.scan())
    return local, drive


def worst(rays: Array, at: Pose2) -> float:
    """How far the ends of rays lie from edges, as seen from a pose [m]."""
    hit = np.isfinite(rays[:, column.RANGE])
    ends = rays[hit, :2] + rays[hit, 3:4] * np.column_stack(
        [np.cos(rays[hit, column.DIRECTION]), np.sin(rays[hit, column.DIRECTION])]
    )
    points, _ = sample(STUB.edges, 0.001)
    return float(max(np.hypot(*(points - end).T).min() for end in at.apply(ends)))


def test_with_exact_odometry_all_rays_end_on_edges_seen_from_the_newest_scan() -> None:
    local, drive = stretch(1.0)
    rays = local.rays(12, 12)
    assert rays.shape == (144, 9)
    assert worst(rays, drive.true) < 0.003
    # What is driven after the newest scan does not count.
    local.move(Pose2(0.1, 0, 0.5))
    np.testing.assert_array_equal(local.rays(12, 12), rays)


def test_with_odometry_that_errs_only_the_newest_fits() -> None:
    local, drive = stretch(1.1)
    assert worst(local.rays(12, 12), drive.true) > 0.02
    assert worst(local.rays(12, 12)[-12:], drive.true) < 0.003


def test_rays_keep_their_ranges_and_limits_of_sight() -> None:
    local = LocalMap(0.0, 0.0, 9)
    scan = Scan(0.0, BEARINGS, np.linspace(0.2, 0.8, 61), sight=np.tile([0.1, 0.7], (61, 1)))
    local.add(scan)
    local.move(Pose2(0.1, 0.0, 0.2))
    local.add(blank())
    rays = local.rays(9, 61)
    assert rays.shape == (122, 9)
    here_from_first = Pose2(0.1, 0.0, 0.2).inverse()
    np.testing.assert_allclose(
        rays[:61, :2], np.tile(here_from_first.apply(np.zeros((1, 2))), (61, 1))
    )
    np.testing.assert_allclose(rays[:61, column.DIRECTION], BEARINGS - 0.2)
    np.testing.assert_array_equal(rays[:61, 3:], rays_of(scan, 61)[:, 3:])
    np.testing.assert_array_equal(rays[61:], rays_of(blank(), 61))


def test_few_of_many_scans_span_the_whole_map() -> None:
    local = driven([Pose2(0.01)] * 20)
    starts = np.unique(local.rays(3, 5)[:, 0].round(6))
    assert len(starts) == 3
    assert starts[0] == pytest.approx(-0.19) and starts[-1] == 0


# --- the way back


def test_the_past_goes_from_the_newest_back_step_by_step() -> None:
    rng = np.random.default_rng(0)
    steps = [Pose2(*rng.normal(0, [0.05, 0.05, 0.5])) for _ in range(10)]
    past = driven(steps).past(10, 61, MOTION)
    assert past.moves.shape == (10, 3) and past.noise.shape == (10, 3, 3)
    assert past.rays.shape == (10, 61, 9)
    np.testing.assert_allclose(past.moves[0], 0, atol=1e-12)
    for move, noise, step in zip(past.moves[1:], past.noise[1:], reversed(steps), strict=False):
        np.testing.assert_allclose(move, step.inverse().to_array(), atol=1e-12)
        np.testing.assert_allclose(noise, MOTION.moments(Pose2(*move))[1], atol=1e-15)


def test_of_some_scans_the_past_has_the_newest_and_the_oldest_and_the_way_between() -> None:
    past = driven([Pose2(0.01 * i) for i in range(10)]).past(4, 7, MOTION)
    assert past.rays.shape == (4, 7, 9)
    np.testing.assert_allclose(-past.moves[:, 0].sum(), 0.45)
    np.testing.assert_allclose(past.noise[0], MOTION.moments(Pose2())[1], atol=1e-15)


def test_the_rays_of_the_past_are_as_each_scan_has_them() -> None:
    local, drive = stretch(1.0)
    past = local.past(8, 30, MOTION)
    pose = drive.true
    for move, rays in zip(past.moves, past.rays, strict=True):
        pose = pose @ Pose2(*move)
        assert worst(rays, pose) < 0.003
    assert math.hypot(pose.x - drive.true.x, pose.y - drive.true.y) > 0.1
