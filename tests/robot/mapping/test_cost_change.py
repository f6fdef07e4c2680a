"""What a step changes of a drive's cost does not jump where edges pass the end of a line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibrations import HAND_BUILT, SEED, SPEC, SQUARE, START_COVARIANCE, driven

from robot.calibration.adjustment import Adjustment, DriveEstimate, Weights, cost_at_gate
from robot.calibration.sightings import Sightings
from robot.calibration.tape_edges import TapeEdges
from robot.calibration.wheel_motion import WheelMotion
from robot.mapping.cost_change import cost_change

WEIGHTS = Weights()
STEPS = np.linspace(0.0, 0.001, 21)
"""How far all pictures are moved along the tape [m]."""


def of_drive() -> tuple[Adjustment, DriveEstimate]:
    """A drive on a square whose sides have a gap of a tenth of their length in their middles."""
    log, true, path = driven(HAND_BUILT, SEED, 18.0)
    part = log.until(100)
    starts, ends = SQUARE.edges[:, :2], SQUARE.edges[:, 2:]
    sides = [starts, 0.55 * starts + 0.45 * ends, 0.45 * starts + 0.55 * ends, ends]
    pieces = np.vstack([np.hstack(sides[:2]), np.hstack(sides[2:])])
    seen = Sightings.of_edges(part, SPEC, TapeEdges.of(pieces))
    adjustment = Adjustment(seen, WheelMotion.of(part, SPEC), path[0], START_COVARIANCE)
    return adjustment, DriveEstimate(true, path[:100], np.zeros((100, 2)))


def moved(state: DriveEstimate, shift: tuple[float, float]) -> DriveEstimate:
    return replace(state, poses=state.poses + np.array([*shift, 0.0]))


def test_edges_that_pass_the_end_of_a_line_make_no_jump() -> None:
    adjustment, state = of_drive()
    errors = adjustment._equations(state, WEIGHTS, None).misses.pixels
    first = adjustment._equations(state, WEIGHTS, errors)
    changes, costs = [], []
    for step in STEPS.tolist():
        then = adjustment._equations(moved(state, (step, 0.0)), WEIGHTS, errors)
        changes.append(cost_change(first, then, WEIGHTS))
        costs.append(then.cost - first.cost)
    assert changes[0] == costs[0] == 0.0
    # How far each lies beside a parabola through its neighbours.
    rough, jumps = (np.abs(np.diff(column, 3)).max() for column in (changes, costs))
    assert jumps > cost_at_gate(WEIGHTS)
    assert rough < 0.2 * jumps


def test_there_and_back_changes_nothing() -> None:
    adjustment, state = of_drive()
    errors = adjustment._equations(state, WEIGHTS, None).misses.pixels
    here = adjustment._equations(state, WEIGHTS, errors)
    there = adjustment._equations(moved(state, (0.013, -0.008)), WEIGHTS, errors)
    forth, back = (cost_change(a, b, WEIGHTS) for a, b in ((here, there), (there, here)))
    assert forth > 100.0
    assert back == pytest.approx(-forth, rel=1e-9)


def test_edges_that_are_lost_aside_cost_as_much_as_the_gate() -> None:
    """Else it would pay to throw all edges out of the gate."""
    adjustment, state = of_drive()
    here = adjustment._equations(state, WEIGHTS, None)
    errors, matched = here.misses.pixels, len(here.misses.residuals)
    there = adjustment._equations(moved(state, (0.3, 0.3)), WEIGHTS, errors)
    change = cost_change(here, there, WEIGHTS)
    assert change > 0.4 * matched * cost_at_gate(WEIGHTS)
