"""Which pairs of edges are tape."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from robot.geometry import Array
from robot.scanning.edge_search import PAIRS
from robot.scanning.tape_edges import Verdict, judge_pairs

LIMITS = (0.012, 0.04, 0.002, 0.006, 0.07)
"""Width's tolerance, support, straightness, taper and the tightest bend [m]."""


def stripe(
    count: int = 21,
    *,
    at: float = 0.4,
    width: float = 0.05,
    slant: float = 0.0,
    step: float = 0.005,
) -> tuple[Array, Array]:
    """Entries and exits (k, PAIRS, 2) of tape across the view, turned by an angle."""
    y = (np.arange(count) - count // 2) * step
    entries, exits = np.full((2, count, PAIRS, 2), np.nan)
    c, s = math.cos(slant), math.sin(slant)
    entries[:, 0] = np.column_stack([at - s * y, c * y])
    exits[:, 0] = entries[:, 0] + (width / c, 0)
    return entries, exits


def judge(entries: Array, exits: Array) -> tuple[NDArray[np.int8], NDArray[np.int8], Array, Array]:
    pairs = np.concatenate([entries, exits], axis=2)
    met = (2 * np.isfinite(entries[..., 0]).sum(axis=1)).astype(np.int32)
    return judge_pairs(pairs, met, np.array([0.05]), *LIMITS)


@pytest.mark.parametrize("slant", [0.0, 0.5, -1.0])
def test_the_width_is_measured_across_the_line(slant: float) -> None:
    chosen, verdicts, widths, lines = judge(*stripe(slant=slant))
    assert (verdicts == Verdict.COUNTED).all() and (chosen == 0).all()
    assert widths == pytest.approx(0.05)
    toward_rays = np.tile([-math.cos(slant), -math.sin(slant)], (21, 1))
    np.testing.assert_allclose(lines[:, :2], toward_rays, atol=1e-9)
    np.testing.assert_allclose(lines[:, 2], -0.4 * math.cos(slant), atol=1e-9)


@pytest.mark.parametrize(("width", "verdict"), [
    (0.0379, Verdict.WRONG_WIDTH), (0.0381, Verdict.COUNTED),
    (0.0619, Verdict.COUNTED), (0.0621, Verdict.WRONG_WIDTH),
])  # fmt: skip
def test_the_width_may_be_off_by_the_tolerance(width: float, verdict: Verdict) -> None:
    _, verdicts, widths, _ = judge(*stripe(width=width))
    assert (verdicts == verdict).all()
    assert widths == pytest.approx(width)


def test_a_ray_with_an_entry_alone_has_no_exit_and_one_out_of_sight_nothing() -> None:
    pairs = np.full((3, PAIRS, 4), np.nan)
    met = np.array([0, 1, -1], np.int32)
    _, verdicts, widths, _ = judge_pairs(pairs, met, np.array([0.05]), *LIMITS)
    assert verdicts.tolist() == [Verdict.NO_EDGE, Verdict.NO_EXIT, Verdict.OUT_OF_SIGHT]
    assert np.isnan(widths).all()


def test_an_edge_must_be_straight() -> None:
    """Around a disc of radius 25 mm the entries bend by far more than 2 mm."""
    angles = np.linspace(-0.9, 0.9, 21)
    entries, exits = np.full((2, 21, PAIRS, 2), np.nan)
    entries[:, 0] = 0.4 - 0.025 * np.column_stack([np.cos(angles), -np.sin(angles)])
    exits[:, 0] = entries[:, 0] + (0.05, 0)
    _, verdicts, widths, _ = judge(entries, exits)
    assert Verdict.COUNTED not in verdicts
    assert np.isnan(widths[verdicts != Verdict.WRONG_WIDTH]).all()


def test_beside_a_corner_the_straight_side_is_enough() -> None:
    entries, exits = stripe(31)
    entries[:15, 0, 0] += 0.005 * np.arange(15, 0, -1)
    exits[:15, 0, 0] = entries[:15, 0, 0] + 0.05 * math.sqrt(2)
    _, verdicts, _, lines = judge(entries, exits)
    assert (verdicts[:13] == Verdict.COUNTED).all()
    assert (verdicts[17:] == Verdict.COUNTED).all()
    np.testing.assert_allclose(lines[20:, 0], -1, atol=1e-6)


def test_too_short_an_edge_is_no_line_and_has_no_normal() -> None:
    """Not even one that was left over from a ray before."""
    entries, exits = stripe(41)
    entries[21:36] = exits[21:36] = np.nan
    _, verdicts, widths, lines = judge(entries, exits)
    assert (verdicts[:21] == Verdict.COUNTED).all()
    assert (verdicts[21:36] == Verdict.NO_EDGE).all()
    assert (verdicts[36:] == Verdict.TOO_SHORT).all()
    assert np.isnan(widths[21:]).all() and np.isnan(lines[21:]).all()


def test_the_nearest_pair_that_counts_is_chosen() -> None:
    entries, exits = stripe(21, at=0.6)
    near_in, near_out = stripe(21, at=0.3, width=0.02)
    entries[:, 1], exits[:, 1] = entries[:, 0], exits[:, 0]
    entries[:, 0], exits[:, 0] = near_in[:, 0], near_out[:, 0]
    chosen, verdicts, widths, _ = judge(entries, exits)
    assert (chosen == 1).all() and (verdicts == Verdict.COUNTED).all()
    assert widths == pytest.approx(0.05)
    both, _, _, _ = judge(*(np.where(np.isnan(a), b, a) for a, b in
                            zip((entries, exits), stripe(21, at=0.6), strict=True)))  # fmt: skip
    assert (both == 1).all()


def test_of_two_tapes_the_nearer_one_is_chosen() -> None:
    entries, exits = stripe(21, at=0.3)
    entries[:, 1], exits[:, 1] = (edge[:, 0] for edge in stripe(21, at=0.6, width=0.055))
    chosen, verdicts, widths, _ = judge(entries, exits)
    assert (chosen == 0).all() and (verdicts == Verdict.COUNTED).all()
    assert widths == pytest.approx(0.05)


def test_entries_of_another_line_lend_no_support() -> None:
    """Neighbours whose nearest pair is on another tape, far away."""
    entries, exits = stripe(21)
    entries[1::2, 0, 0] += 0.3
    exits[1::2, 0, 0] += 0.3
    _, verdicts, _, _ = judge(entries, exits)
    assert Verdict.COUNTED not in verdicts


@pytest.mark.parametrize(
    ("change", "counts"), [(0.004, True), (0.02, False), (-0.004, True), (-0.02, False)]
)
def test_the_width_must_stay_what_it_is(change: float, counts: bool) -> None:
    """The end of a shoe has a straight edge too, and is as wide as tape somewhere."""
    entries, exits = stripe(21)
    exits[:, 0, 0] += change * np.linspace(-1, 1, 21)
    _, verdicts, _, _ = judge(entries, exits)
    assert (verdicts[10] == Verdict.COUNTED) == counts
    if not counts:
        assert Verdict.COUNTED not in verdicts


def test_noise_is_averaged_along_the_edge() -> None:
    rng = np.random.default_rng(0)
    entries, exits = stripe(41)
    entries[:, 0, 0] += rng.normal(0, 0.3e-3, 41)
    _, verdicts, _, lines = judge(entries, exits)
    assert (verdicts == Verdict.COUNTED).all()
    across = lines[:, 0] * 0.4 + lines[:, 1] * entries[:, 0, 1] - lines[:, 2]
    assert across[5:-5].std() < 0.15e-3


@pytest.mark.parametrize("radius", [0.115, 0.165, 0.25])
def test_a_curved_edge_is_not_straightened(radius: float) -> None:
    """The chord of 40 mm lies up to 1.7 mm inside the curve."""
    angles = np.arange(-20, 21) * 0.004 / radius
    entries, exits = np.full((2, 41, PAIRS, 2), np.nan)
    turned = np.column_stack([np.cos(angles), np.sin(angles)])
    centre = np.array([0.4 + radius, 0])
    entries[:, 0] = centre - radius * turned
    exits[:, 0] = centre - (radius - 0.05) * turned
    _, verdicts, widths, lines = judge(entries, exits)
    inner = slice(10, -10)
    assert (verdicts[inner] == Verdict.COUNTED).all()
    off = (lines[inner, :2] * entries[inner, 0]).sum(axis=1) - lines[inner, 2]
    assert np.abs(off).max() < 0.1e-3
    assert np.abs(widths[inner] - 0.05).max() < 0.5e-3


@pytest.mark.parametrize(("radius", "is_tape"), [(0.055, False), (0.085, True)])
def test_a_bend_that_is_tighter_than_tape_bends_does_not_count(
    radius: float, is_tape: bool
) -> None:
    """The limit is 70 mm."""
    angles = np.arange(-20, 21) * 0.003 / radius
    entries, exits = np.full((2, 41, PAIRS, 2), np.nan)
    turned = np.column_stack([np.cos(angles), np.sin(angles)])
    entries[:, 0] = (0.4 - radius, 0) + radius * turned
    exits[:, 0] = (0.4 - radius, 0) + (radius + 0.05) * turned
    _, verdicts, _, _ = judge(entries, exits)
    assert ((verdicts[10:-10] == Verdict.COUNTED) == is_tape).all()


def test_an_edge_goes_on_beside_a_corner() -> None:
    """There, rays leave the tape through another one: their width says nothing."""
    entries, exits = stripe(31)
    exits[22:, 0, 0] -= 0.04
    _, verdicts, widths, lines = judge(entries, exits)
    assert (verdicts == Verdict.COUNTED).all()
    np.testing.assert_allclose(lines[22:, 2], -0.4, atol=1e-6)
    assert widths == pytest.approx(0.05, abs=1e-3)


def test_an_edge_goes_on_no_farther_than_it_was_sure() -> None:
    """Else a short straight stretch of a blob would count the whole blob."""
    entries, exits = stripe(41)
    exits[12:, 0, 0] += 0.04
    _, verdicts, _, _ = judge(entries, exits)
    sure = int(np.flatnonzero(verdicts == Verdict.WRONG_WIDTH)[0])
    assert 12 < sure <= 24
    assert Verdict.COUNTED not in verdicts[sure:]


def test_what_lies_off_the_line_does_not_go_on() -> None:
    entries, exits = stripe(31)
    entries[22:, 0, 0] += 0.01
    exits[22:, 0, 0] -= 0.04
    _, verdicts, _, _ = judge(entries, exits)
    assert Verdict.COUNTED not in verdicts[22:]


def test_rays_far_apart_support_each_other_along_a_grazed_edge() -> None:
    _, verdicts, _, _ = judge(*stripe(9, step=0.06))
    assert (verdicts == Verdict.COUNTED).all()
