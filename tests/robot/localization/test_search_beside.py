"""Every filter's claim rests on a search of the field, its own or one beside it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from square_drive import NARROW, ON_SQUARE, ON_STUB, drive_on
from stub_drive import Drive

from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, Standing, State
from robot.localization.filter import Setup
from robot.localization.filter_kinds import FILTERS
from robot.localization.localizer import Localizer, make_filter, search_beside
from robot.localization.monitoring.monitor import Monitor
from robot.localization.search_beside import usual

LONE = [name for name, kind in FILTERS.items() if not kind.has_hypotheses]
"""Filters that make no search."""


def with_filter(setup: Setup, name: str) -> Setup:
    parameters = setup.parameters
    return replace(
        setup, parameters=replace(parameters, filter=replace(parameters.filter, filter=name))
    )


def localizer(on: Setup, name: str) -> Localizer:
    setup = with_filter(on, name)
    return Localizer.of(
        make_filter(setup, np.random.default_rng(0)), setup, Monitor(setup.evidence)
    )


def states(one: Localizer, drive: Drive, seconds: float) -> Iterator[tuple[State, bool]]:
    """What is claimed after each scan, and whether the estimate is right."""
    for _, scan in drive.eight(seconds):
        estimate = one.update(drive.odometry, scan)
        near = estimate is not None and estimate.pose.distance_to(drive.true) < 0.03
        yield one.integrity.state, near


@pytest.mark.slow
@pytest.mark.parametrize("name", LONE)
def test_where_places_look_alike_and_nothing_was_told_none_is_certain(name: str) -> None:
    """On a square one cloud, one Gaussian and often a grid settle at one of four equal places."""
    one, drive = localizer(ON_SQUARE, name), drive_on(ON_SQUARE.field, Pose2(0.1, 0.05, 0.5))
    one.scatter()
    assert not {state for state, _ in states(one, drive, 8.0)} & set(BOUNDED)


@pytest.mark.slow
@pytest.mark.parametrize("name", LONE)
def test_a_place_that_was_told_rightly_is_given_and_then_certain(name: str) -> None:
    one, drive = localizer(ON_STUB, name), Drive(Pose2(0.1, 0.05, 0.5))
    one.set_pose(drive.true, NARROW)
    claimed = [state for state, right in states(one, drive, 10.0) if right]
    assert claimed[0] is State.GIVEN and claimed[-1] is State.CERTAIN
    assert set(claimed) == set(BOUNDED)


@pytest.mark.slow
@pytest.mark.parametrize("name", LONE)
def test_at_another_place_than_the_search_finds_nothing_is_certain(name: str) -> None:
    one, drive = localizer(ON_STUB, name), Drive(Pose2(0.1, 0.05, 0.5))
    one.set_pose(drive.true, NARROW)
    list(states(one, drive, 10.0))
    drive.true = Pose2(-0.2, 0.1, 2.5)
    assert not [s for s, right in list(states(one, drive, 5.0))[30:] if s in BOUNDED and not right]


@pytest.mark.slow
def test_a_place_that_was_in_doubt_is_so_for_another_filter_too() -> None:
    """A cloud at one of four equal places is no start that somebody gave."""
    one, drive = localizer(ON_SQUARE, "particles"), drive_on(ON_SQUARE.field, Pose2(0.1, 0, 0.5))
    one.scatter()
    list(states(one, drive, 4.0))
    for name in ("hypotheses", "kalman"):
        setup = with_filter(ON_SQUARE, name)
        one.exchange(make_filter(setup, np.random.default_rng(1)), setup)
        assert not {state for state, _ in states(one, drive, 2.0)} & set(BOUNDED)


def test_a_place_that_was_given_stays_so_for_another_filter() -> None:
    one, drive = localizer(ON_STUB, "hypotheses"), Drive(Pose2(0.1, 0.05, 0.5))
    one.set_pose(drive.true, NARROW)
    list(states(one, drive, 0.3))
    setup = with_filter(ON_STUB, "particles")
    one.exchange(make_filter(setup, np.random.default_rng(1)), setup)
    assert one.beside is not None and one.beside.filter.standing is Standing.GIVEN
    assert {state for state, _ in states(one, drive, 0.3)} == {State.GIVEN}


@pytest.mark.slow
@pytest.mark.parametrize(
    "off", [(-0.02, -0.106, -0.192), (0.009, 0.091, 0.101), (0.06, -0.063, -0.133)]
)
def test_a_wide_start_outlives_a_gaussian_that_has_not_come_to_it(
    off: tuple[float, float, float],
) -> None:
    """On a square no search would find again which of four equal places was given."""
    one, drive = localizer(ON_SQUARE, "kalman"), drive_on(ON_SQUARE.field, Pose2(0.1, 0, 0.5))
    told = Pose2.from_array(drive.true.to_array() + off)
    one.set_pose(told, ON_SQUARE.parameters.filter.initial_covariance)
    list(states(one, drive, 0.1))
    setup = with_filter(ON_SQUARE, "hypotheses")
    one.exchange(make_filter(setup, np.random.default_rng(1)), setup)
    claimed = list(states(one, drive, 10.0))
    assert claimed[-1] == (State.CERTAIN, True)


def test_what_searches_goes_on_whatever_filter_is_chosen() -> None:
    one = localizer(ON_STUB, "hypotheses")
    searching = one.filter
    for name in ("particles", *LONE, "hypotheses"):
        setup = with_filter(ON_STUB, name)
        one.exchange(make_filter(setup, np.random.default_rng(1)), setup)
        assert searching is (one.filter if one.beside is None else one.beside.filter)
    assert one.filter is searching


def test_it_is_made_where_a_filter_makes_no_search_and_there_is_tape() -> None:
    assert search_beside(with_filter(ON_STUB, "hypotheses")) is None
    alone = with_filter(ON_STUB, "particles")
    assert search_beside(alone) is not None
    assert search_beside(replace(alone, field=replace(alone.field, tape=()))) is None


def test_parameters_that_are_idle_change_nothing_in_it() -> None:
    p = ON_STUB.parameters
    other = replace(
        p,
        sensor=replace(p.sensor, z_hit=0.3, laser_model_type="beam"),
        filter=replace(p.filter, max_particles=600, resample_interval=7),
        hypotheses=replace(p.hypotheses, kidnapped=1e-2, map_scans=8),
    )
    changed = usual(replace(ON_STUB, parameters=other)).parameters
    assert changed == usual(ON_STUB).parameters
