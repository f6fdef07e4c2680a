"""A search finds the places where a short map fits, and does its work in small pieces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from stub_drive import DEFAULTS, ENTRIES, MAPS, SENSOR, STUB, Drive, near

from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.localization.filter import Setup
from robot.localization.hypotheses import place_search
from robot.localization.hypotheses.coarse_grid import CoarseGrid
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.hypotheses.place_search import (
    FITS_PER_PIECE,
    PEAKS,
    POSES_PER_PIECE,
    REPLAYED_SCANS,
    REPLAYS_PER_PIECE,
    PlaceSearch,
)
from robot.localization.hypotheses.rescoring import Rescored
from robot.localization.models.entry_field import EntryField
from robot.localization.models.sensor_models import sensor_model
from robot.localization.parameters import HypothesisParameters
from robot.localization.scan_matching import Match

SQUARE = load_field("square", MAPS)
SETUPS = {STUB.name: Setup.of(STUB, ENTRIES, DEFAULTS.motion.model(), SENSOR, DEFAULTS)}
_table = EntryField.build(SQUARE, resolution=0.005, max_distance=0.15)
SETUPS[SQUARE.name] = Setup.of(
    SQUARE,
    _table,
    DEFAULTS.motion.model(),
    sensor_model(DEFAULTS.sensor, _table, SQUARE.edges),
    DEFAULTS,
)


def drawn(seed: int) -> Pose2:
    """A start from which the eight stays on the field for a while."""
    rng = np.random.default_rng(seed)
    return Pose2.from_array(rng.uniform([-0.2, -0.2, -3.1], [0.2, 0.2, 3.1]))


def searched(
    start: Pose2,
    of: Field = STUB,
    seconds: float = 1.2,
    alive: list[Pose2] | None = None,
    parameters: HypothesisParameters = DEFAULTS.hypotheses,
) -> tuple[PlaceSearch, Pose2]:
    """A search that has begun, and the true pose at its newest scan."""
    setup, drive = SETUPS[of.name], Drive(start, edges_of=of)
    setup = replace(setup, parameters=replace(setup.parameters, hypotheses=parameters))
    local = LocalMap(parameters.map_step_xy, parameters.map_step_theta, parameters.map_scans)
    for moved, scan in drive.eight(seconds):
        local.move(moved)
        if local.add(scan):
            end = drive.true
    return PlaceSearch(local, alive or [], setup), end


def done(search: PlaceSearch) -> PlaceSearch:
    for _ in range(1000):
        if search.advance():
            return search
    raise AssertionError("a search ends")


def at(found: list[Rescored], pose: Pose2) -> list[Rescored]:
    return [life for life in found if near(life.pose, pose, 0.01, math.radians(2))]


# --- what it finds


@pytest.mark.parametrize("seed", range(6))
def test_the_true_place_is_among_those_found(seed: int) -> None:
    search, end = searched(drawn(seed))
    done(search)
    (there,) = at(search.found, end)
    best = max(float(life.fits.mean()) for life in search.found)
    assert there.fits.mean() > best - 0.1
    assert len(search.found) <= DEFAULTS.hypotheses.max_hypotheses


@pytest.mark.parametrize("seed", range(3))
def test_on_a_plain_square_all_four_places_are_found_and_fit_alike(seed: int) -> None:
    search, end = searched(drawn(seed), SQUARE)
    done(search)
    four = [at(search.found, Pose2(0, 0, n * math.pi / 2) @ end) for n in range(4)]
    assert [len(found) for found in four] == [1] * 4
    values = [found[0].fits.mean() for found in four]
    assert np.ptp(values) < 0.05
    assert max(float(life.fits.mean()) for life in search.found) < max(values) + 0.05


def test_places_found_differ_from_each_other() -> None:
    search, _ = searched(drawn(0), SQUARE)
    found = [life.pose for life in done(search).found]
    assert len(found) >= 4
    for i, one in enumerate(found):
        assert not any(DEFAULTS.hypotheses.alike(one, other) for other in found[:i])


def test_no_more_places_are_found_than_may_be_followed_and_they_are_the_best() -> None:
    start = drawn(1)
    few, _ = searched(start, SQUARE, parameters=replace(DEFAULTS.hypotheses, max_hypotheses=2))
    many, _ = searched(start, SQUARE)
    found = [life.pose for life in done(few).found]
    assert found == [life.pose for life in done(many).found[:2]]


def test_what_is_alive_is_lived_through_though_it_is_not_found() -> None:
    """So that newcomers are measured against what is believed."""
    wrong = Pose2(-0.1, 0.2, -2.0)
    search, end = searched(Pose2(), alive=[])
    both, _ = searched(Pose2(), alive=[end @ Pose2(0.005, 0.005, 0.02), wrong])
    assert done(search).alive == []
    right, other = done(both).alive
    (there,) = at(both.found, end)
    assert near(right.pose, end, 0.01, 0.03)
    assert right.fits.mean() == pytest.approx(there.fits.mean(), abs=0.05)
    assert other.fits.mean() < right.fits.mean() - 1


def test_a_robot_beside_the_drive_area_is_found_if_it_is_likely_to_be_near() -> None:
    """It stands beside the outer corner of the tape."""
    start = Pose2(-0.7, -0.7, 0.2)
    elsewhere, end = searched(start, seconds=0.8)
    assert not at(done(elsewhere).found, end)
    near_by, _ = searched(start, seconds=0.8, alive=[end @ Pose2(0.12, -0.06, 0.2)])
    assert at(done(near_by).found, end)


def test_it_finds_what_the_map_held_when_it_began() -> None:
    parameters, setup, drive = DEFAULTS.hypotheses, SETUPS["stub"], Drive()
    local = LocalMap(parameters.map_step_xy, parameters.map_step_theta, parameters.map_scans)
    for moved, scan in drive.eight(1.2):
        local.move(moved)
        if local.add(scan):
            end = drive.true
    search = PlaceSearch(local, [], setup)
    scans = search.scans
    while not search.advance():
        moved, scan = next(iter(drive.eight(0.04)))
        local.move(moved)
        local.add(scan)
    assert search.scans == scans < len(local)
    assert at(search.found, end)


def test_a_life_has_as_many_scans_as_are_lived() -> None:
    search, _ = searched(Pose2())
    assert search.scans > REPLAYED_SCANS == search.scans_replayed
    assert {len(life.fits) for life in done(search).found} == {REPLAYED_SCANS}
    short, _ = searched(Pose2(), seconds=0.2)
    assert short.scans == short.scans_replayed < REPLAYED_SCANS


def test_rays_that_returned_nothing_are_no_ends() -> None:
    """A drive off the field: no end to score, no place, and no failure."""
    search, _ = searched(Pose2(2.0, 2.0, 0.5))
    done(search)
    assert len(search.found) <= DEFAULTS.hypotheses.max_hypotheses
    for life in search.found:
        assert life.pose.is_finite() and np.isfinite(life.fits).all()


# --- how much at once


def test_no_piece_of_the_work_is_large(monkeypatch: pytest.MonkeyPatch) -> None:
    work = {"poses": 0, "fits": 0, "lives": 0}
    score, fit, live = CoarseGrid.score, PlaceSearch._match, PlaceSearch._replayed

    def scored(
        self: CoarseGrid,
        turns: slice,
        ends: Array,
        entries: EntryField,
        blur: float,
        costs: NDArray[np.float32],
    ) -> None:
        work["poses"] += costs[turns].size
        score(self, turns, ends, entries, blur, costs)

    def fitted(self: PlaceSearch, start: Pose2) -> Match:
        work["fits"] += 1
        return fit(self, start)

    def lived(self: PlaceSearch, pose: Pose2) -> Rescored:
        work["lives"] += 1
        return live(self, pose)

    monkeypatch.setattr(CoarseGrid, "score", scored)
    monkeypatch.setattr(PlaceSearch, "_match", fitted)
    monkeypatch.setattr(PlaceSearch, "_replayed", lived)
    search, end = searched(drawn(2), alive=[Pose2()])
    pieces = []
    while not search.advance():
        pieces.append(dict(work))
        work.update(poses=0, fits=0, lives=0)
    pieces.append(dict(work))
    assert 0 < max(piece["poses"] for piece in pieces) <= POSES_PER_PIECE
    assert max(piece["fits"] for piece in pieces) <= FITS_PER_PIECE
    assert max(piece["lives"] for piece in pieces) <= REPLAYS_PER_PIECE
    assert all(sum(count > 0 for count in piece.values()) <= 1 for piece in pieces[:-1])
    grid = CoarseGrid.over(
        STUB.drive_area, DEFAULTS.hypotheses.search_step_xy, DEFAULTS.hypotheses.search_step_theta
    )
    assert sum(piece["poses"] for piece in pieces) == math.prod(grid.shape)
    assert sum(piece["fits"] for piece in pieces) <= PEAKS + 1
    assert sum(piece["lives"] for piece in pieces) == len(search.found) + 1
    assert at(search.found, end)


def test_also_where_one_heading_is_more_than_a_piece_it_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(place_search, "POSES_PER_PIECE", 10)
    search, end = searched(drawn(3))
    pieces = 1
    while not search.advance():
        pieces += 1
    assert pieces > 60
    assert at(search.found, end)


def test_done_it_stays_done() -> None:
    search, _ = searched(Pose2())
    found = list(done(search).found)
    assert search.advance() and search.advance()
    assert search.found == found
