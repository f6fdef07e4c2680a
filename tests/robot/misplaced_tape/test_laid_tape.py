"""Tape that lies beside its drawing: its parts, and how they move."""

from __future__ import annotations

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.fields.edges import lengths, sample
from robot.fields.field_loading import load_field
from robot.misplaced_tape.laid_tape import APART, LONGEST_PART, STEP, LaidTape

FIELDS = ("square", "town", "generated-9", "generated-17")


@pytest.mark.parametrize("name", FIELDS)
def test_parts_are_short_and_make_up_the_drawing(name):
    edges = load_field(name, MAPS).edges
    tape = LaidTape(edges)
    parts = tape.laid(np.zeros(len(tape.prior)))
    assert lengths(parts).max() <= LONGEST_PART + 1e-9
    assert lengths(parts).sum() == pytest.approx(lengths(edges).sum())


@pytest.mark.parametrize("name", FIELDS)
def test_centres_are_spread_over_all_tape(name):
    edges = load_field(name, MAPS).edges
    centres = LaidTape(edges).centres
    apart = np.hypot(*(centres[:, None] - centres[None]).transpose(2, 0, 1))
    assert apart[~np.eye(len(centres), dtype=bool)].min() > APART
    points, _ = sample(edges, STEP)
    nearest = np.hypot(*(points[:, None] - centres[None]).transpose(2, 0, 1)).min(axis=1)
    assert nearest.max() <= APART


def test_a_larger_floor_has_all_tape_farther_from_the_origin():
    tape = LaidTape(load_field("square", MAPS).edges)
    offsets = np.zeros(len(tape.prior))
    offsets[-1] = 0.03
    assert tape.laid(offsets) == pytest.approx(1.03 * tape.laid(np.zeros(len(offsets))))


@pytest.mark.parametrize("name", FIELDS)
def test_centres_that_all_move_alike_move_all_tape_so(name):
    tape = LaidTape(load_field(name, MAPS).edges)
    count = len(tape.centres)
    offsets = np.concatenate([np.full(count, 0.01), np.full(count, -0.02), [0.0]])
    moves = tape.laid(offsets) - tape.laid(np.zeros(len(offsets)))
    # Half way between two centres a little less.
    assert np.abs(moves - np.tile([0.01, -0.02], 2)).max() < 0.2 * 0.02


def test_tape_as_drawn_does_not_move():
    tape = LaidTape(load_field("square", MAPS).edges, scales=False, bends=False)
    assert len(tape.centres) == 0
    assert not tape.prior.any()


@pytest.mark.parametrize("name", FIELDS)
def test_offsets_that_are_drawn_from_the_prior_are_likely(name):
    """Its text: about normal, so hardly one in a thousand is beyond 3."""
    tape, rng = LaidTape(load_field(name, MAPS).edges), np.random.default_rng(1)
    drawn = rng.multivariate_normal(np.zeros(len(tape.prior)), tape.prior, 500)
    values = np.array([tape.unlikelihood(offsets) for offsets in drawn])
    assert abs(values.mean()) < 0.2
    assert 0.8 < values.std() < 1.2
    assert tape.unlikelihood(3 * drawn[0]) > 5
