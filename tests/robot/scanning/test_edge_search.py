"""Edges along rays: found to the sample, then between the pixels, and not in noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from robot.scanning.edge_search import (
    PAIRS,
    differences,
    find_edges,
    find_pairs,
)
from robot.scanning.picture_noise import kernel_for, noise_of

LIGHT, DARK = 200, 40


def response(*edges: tuple[float, float], length: int = 120) -> NDArray[np.int16]:
    """Summed responses (m,) for a half width of 2, with peaks of these heights at these samples."""
    at = np.arange(length)
    total = sum(height * np.exp(-0.5 * ((at - sample) / 1.5) ** 2) for sample, height in edges)
    return np.rint(2 * np.asarray(total)).astype(np.int16)


def pairs_of(answers: NDArray[np.int16]) -> tuple[list[tuple[int, int]], int]:
    pairs = np.zeros((PAIRS, 2, 2), dtype=np.int32)
    met = find_pairs(answers, 2, 25.0, pairs, np.empty(2))
    return [(int(entry), int(leave)) for entry, leave in pairs[: met // 2, :, 0]], met


def single_of(answers: NDArray[np.int16]) -> list[float]:
    single = np.empty(2)
    find_pairs(answers, 2, 25.0, np.zeros((PAIRS, 2, 2), dtype=np.int32), single)
    result: list[float] = single.tolist()
    return result


@pytest.mark.parametrize(
    ("edges", "valid"),
    [
        ([(40, -90), (80, 90)], [(40, 80)]),
        ([(40, -20), (80, 90)], []),  # too weak to enter
        ([(40, -90), (80, 20)], []),  # too weak to leave
        ([(40, 90), (80, -90)], []),  # from dark to light and back
        ([(30, 90), (50, -90), (80, 90)], [(50, 80)]),
        ([(30, -50), (50, -90), (80, 90)], [(50, 80)]),  # the sharper of two entries
        ([(30, -90), (50, -50), (80, 90)], [(30, 80)]),
        ([(30, -90), (60, 50), (80, 90)], [(30, 60)]),  # the first exit
        ([(20, -90), (40, 90), (60, -90), (80, 90)], [(20, 40), (60, 80)]),
        ([(40, -90), (43, 90)], [(40, 43)]),  # far tape: no sample between is below the threshold
    ],
)
def test_pairs_are_an_entry_and_the_next_exit(
    edges: list[tuple[float, float]], valid: list[tuple[int, int]]
) -> None:
    assert pairs_of(response(*edges))[0] == valid


def test_an_entry_without_an_exit_is_counted_as_one() -> None:
    assert pairs_of(response((40, -90)))[1] == 1
    assert pairs_of(response((20, -90), (40, 90), (60, -90)))[1] == 3


def test_of_many_pairs_the_nearest_are_kept() -> None:
    edges = [(15.0 + 12 * i, -90.0 if i % 2 == 0 else 90.0) for i in range(12)]
    pairs, met = pairs_of(response(*edges, length=180))
    assert met == 2 * PAIRS
    assert pairs == [(15, 27), (39, 51), (63, 75), (87, 99)]


def test_the_kernel_looks_past_no_end() -> None:
    """Samples after the last one in use hold anything."""
    grey = np.full((1, 40), LIGHT, dtype=np.int16)
    grey[0, 30:] = DARK
    assert not differences(grey, np.array([30], dtype=np.int32), 2).any()
    assert differences(grey, np.array([40], dtype=np.int32), 2)[0, 29] == 2 * (DARK - LIGHT)
    for count in range(8):
        assert not differences(grey, np.array([count], dtype=np.int32), 3).any()


@pytest.mark.parametrize("sd", [0.0, 2.0, 8.0, 15.0, 40.0])
def test_noise_is_measured_beside_edges_and_slopes(sd: float) -> None:
    rng = np.random.default_rng(0)
    floor = np.linspace(180, 120, 400) - 60.0 * (np.arange(400) // 50 % 2)
    grey = np.rint(floor + rng.normal(0, sd, (90, 400))).astype(np.int16)
    measured = noise_of(grey, np.full(90, 400, dtype=np.int32), 1)
    assert measured == pytest.approx(sd, abs=0.5, rel=0.1)


def test_without_samples_there_is_no_noise() -> None:
    assert noise_of(np.zeros((3, 5), dtype=np.int16), np.zeros(3, dtype=np.int32), 1) == 0


def test_noise_widens_the_kernel_and_then_raises_the_threshold() -> None:
    assert kernel_for(0.0, 2, 25.0) == (2, 25.0)
    assert kernel_for(3.0, 2, 25.0) == (2, 25.0)
    assert kernel_for(8.0, 2, 25.0)[0] == 3
    half, threshold = kernel_for(15.0, 2, 25.0)
    assert half == 3
    assert threshold == pytest.approx(3.5 * 15 * math.sqrt(2 / 3))


@pytest.mark.parametrize(
    ("edges", "single"),
    [
        ([(40, 0)], (math.nan, math.nan)),
        ([(40, -20), (80, 20)], (math.nan, math.nan)),  # too weak
        ([(40, -90), (80, 90)], (math.nan, math.nan)),
        ([(40, -90), (60, 90), (80, 90)], (math.nan, math.nan)),
        ([(40, -90)], (math.nan, 40)),
        ([(20, -90), (40, 90), (60, -90)], (math.nan, 60)),
        ([(30, 90)], (30, math.nan)),  # begins in something dark
        ([(20, 90), (30, 90), (50, -90), (80, 90)], (30, math.nan)),
        ([(30, 90), (50, -90)], (30, 50)),
    ],
)
def test_an_exit_without_entry_and_an_entry_without_exit_are_told(
    edges: list[tuple[float, float]], single: tuple[float, float]
) -> None:
    assert single_of(response(*edges)) == pytest.approx(single, nan_ok=True)


def vertical_ray(length: int = 60) -> tuple[NDArray[np.uint32], NDArray[np.float32]]:
    """One ray up a picture 40 pixels wide, a sample a pixel, half a pixel beside the columns."""
    rows = 80 - np.arange(length)
    pixels = np.column_stack([np.full(length, 20.5), rows]).astype(np.float32)
    return (rows * 40 + 20).astype(np.uint32)[None], pixels[None]


def blurred_stripe(first: float, last: float, sd: float = 0.7) -> NDArray[np.uint8]:
    """A picture (90, 40), dark between two rows with fractions, its edges blurred."""
    erf = np.vectorize(math.erf)
    rows = np.arange(90.0)
    inside = erf((rows - first) / (sd * math.sqrt(2))) - erf((rows - last) / (sd * math.sqrt(2)))
    column = LIGHT + (DARK - LIGHT) * inside / 2
    return np.rint(np.repeat(column[:, None], 40, axis=1)).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [0.0, 0.2, 0.5, 0.77])
@pytest.mark.parametrize("sd", [0.5, 0.7, 1.0])
def test_an_edge_is_found_between_the_pixels(shift: float, sd: float) -> None:
    pixel_indices, pixels = vertical_ray()
    picture = blurred_stripe(40 + shift, 60 + shift, sd)
    counts = np.array([60], dtype=np.int32)
    edges, met, _, noise, half, _ = find_edges(picture, pixel_indices, counts, pixels, 1, 2, 25.0)
    assert met[0] == 2 and half == 2 and noise == 0
    assert edges[0, 0] == pytest.approx([20 - shift, 40 - shift], abs=0.05)
    assert np.isnan(edges[0, 1:]).all()


@pytest.mark.parametrize("beyond", [0, 255])
def test_a_search_that_would_leave_the_picture_stays_at_its_sample(beyond: int) -> None:
    """It goes straight on where the ray turns aside, as a lens may bend it, and before the border.

    The lower edge is blurred, so it is searched far and wide.
    """
    memory = np.full((180, 40), beyond, dtype=np.uint8)
    picture = memory[45:135]
    picture[:70] = blurred_stripe(50.3, 110)[:70]
    picture[70:] = blurred_stripe(30, 84.3, 4.0)[70:]
    rows = np.minimum(28 + np.arange(70), 86)
    pixels = np.column_stack([np.full(70, 20.5), rows]).astype(np.float32)[None]
    pixel_indices = (rows * 40 + 20).astype(np.uint32)[None]
    edges, met, *_ = find_edges(
        picture, pixel_indices, np.array([70], dtype=np.int32), pixels, 1, 2, 5.0
    )
    assert met[0] == 2
    assert edges[0, 0, 0] == pytest.approx(22.3, abs=0.05)
    assert edges[0, 0, 1] == 54


def test_rays_out_of_sight_meet_minus_one_edge() -> None:
    pixel_indices, pixels = vertical_ray()
    edges, met, *_ = find_edges(
        blurred_stripe(40, 60), pixel_indices, np.zeros(1, dtype=np.int32), pixels, 1, 2, 25.0
    )
    assert met[0] == -1 and np.isnan(edges).all()
