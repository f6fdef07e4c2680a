"""Pairs of edges along rays, and which of them are tape."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from robot.geometry import Array
from robot.scanning.tape_edges import PAIRS, Verdict, find_pairs, judge_pairs


def answer(*edges: tuple[float, float], length: int = 120) -> NDArray[np.float32]:
    """An edge kernel's answer (1, m) with peaks of a height at places."""
    at = np.arange(length)
    total = sum(height * np.exp(-0.5 * ((at - place) / 1.5) ** 2) for place, height in edges)
    return np.asarray(total, dtype=np.float32)[None]


def pairs_of(response: NDArray[np.float32]) -> tuple[Array, int]:
    counts = np.array([response.shape[1]], dtype=np.int32)
    pairs, found = find_pairs(response, counts, 25.0, 4)
    return pairs[0], int(found[0])


@pytest.mark.parametrize("place", [40.0, 40.25, 40.5, 40.9])
def test_an_edge_is_found_between_samples(place: float) -> None:
    pairs, found = pairs_of(answer((place, -90), (80.4, 90)))
    assert found == 2
    assert pairs[0] == pytest.approx([place, 80.4], abs=0.03)
    assert np.isnan(pairs[1:]).all()


@pytest.mark.parametrize(
    ("edges", "valid"),
    [
        ([(40, -20), (80, 90)], []),  # too weak to enter
        ([(40, -90), (80, 20)], []),  # too weak to leave
        ([(40, 90), (80, -90)], []),  # from dark to light and back
        ([(30, 90), (50, -90), (80, 90)], [(50, 80)]),
        ([(30, -50), (50, -90), (80, 90)], [(50, 80)]),  # the sharper of two entries
        ([(30, -90), (50, -50), (80, 90)], [(30, 80)]),
        ([(20, -90), (40, 90), (60, -90), (80, 90)], [(20, 40), (60, 80)]),
        ([(2, -90), (80, 90)], []),  # where the kernel looks past the end
    ],
)
def test_pairs_are_an_entry_and_the_next_exit(
    edges: list[tuple[float, float]], valid: list[tuple[float, float]]
) -> None:
    pairs, _ = pairs_of(answer(*edges))
    np.testing.assert_allclose(pairs[: len(valid)].reshape(-1, 2), valid or np.empty((0, 2)),
                               atol=0.1)  # fmt: skip
    assert np.isnan(pairs[len(valid) :]).all()


def test_an_entry_without_an_exit_is_counted_as_one() -> None:
    assert pairs_of(answer((40, -90)))[1] == 1
    assert pairs_of(answer((20, -90), (40, 90), (60, -90)))[1] == 3


def test_of_many_pairs_the_nearest_are_kept() -> None:
    edges = [(15.0 + 12 * i, -90.0 if i % 2 == 0 else 90.0) for i in range(12)]
    pairs, found = pairs_of(answer(*edges, length=180))
    assert found == 2 * PAIRS
    assert pairs[:, 0] == pytest.approx([15, 39, 63, 87], abs=0.1)


def test_samples_that_are_not_in_use_are_not_searched() -> None:
    response = answer((40, -90), (80, 90))
    pairs, _ = find_pairs(response, np.array([60], dtype=np.int32), 25.0, 4)
    assert np.isnan(pairs).all()


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
    return judge_pairs(entries, exits, 0.05, 0.012, 0.04, 0.002)


@pytest.mark.parametrize("slant", [0.0, 0.5, -1.0])
def test_the_width_is_measured_across_the_line(slant: float) -> None:
    chosen, verdicts, widths, normals = judge(*stripe(slant=slant))
    assert (verdicts == Verdict.COUNTED).all() and (chosen == 0).all()
    assert widths == pytest.approx(0.05)
    toward_rays = np.tile([-math.cos(slant), -math.sin(slant)], (21, 1))
    np.testing.assert_allclose(normals, toward_rays, atol=1e-9)


@pytest.mark.parametrize(("width", "verdict"), [
    (0.0379, Verdict.WRONG_WIDTH), (0.0381, Verdict.COUNTED),
    (0.0619, Verdict.COUNTED), (0.0621, Verdict.WRONG_WIDTH),
])  # fmt: skip
def test_the_width_may_be_off_by_the_tolerance(width: float, verdict: Verdict) -> None:
    _, verdicts, widths, _ = judge(*stripe(width=width))
    assert (verdicts == verdict).all()
    assert widths == pytest.approx(width)


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
    _, verdicts, _, normals = judge(entries, exits)
    assert (verdicts[:13] == Verdict.COUNTED).all()
    assert (verdicts[17:] == Verdict.COUNTED).all()
    np.testing.assert_allclose(normals[20:, 0], -1, atol=1e-6)


def test_too_short_an_edge_is_no_line_and_has_no_normal() -> None:
    """Not even one that was left over from a ray before."""
    entries, exits = stripe(41)
    entries[21:36] = exits[21:36] = np.nan
    _, verdicts, widths, normals = judge(entries, exits)
    assert (verdicts[:21] == Verdict.COUNTED).all()
    assert (verdicts[21:36] == Verdict.NO_EDGE).all()
    assert (verdicts[36:] == Verdict.TOO_SHORT).all()
    assert np.isnan(widths[21:]).all() and np.isnan(normals[21:]).all()


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


def test_entries_of_another_line_lend_no_support() -> None:
    """Neighbours whose nearest pair is on another tape, far away."""
    entries, exits = stripe(21)
    entries[1::2, 0, 0] += 0.3
    exits[1::2, 0, 0] += 0.3
    _, verdicts, _, _ = judge(entries, exits)
    assert Verdict.COUNTED not in verdicts
