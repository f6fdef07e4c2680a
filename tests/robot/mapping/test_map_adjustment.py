"""A long drive is adjusted in parts, which add up to the whole of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from calibrations import SPEC, driven
from mappings import WIDTH, Tour, eight, errors_of, mapped

from app.settings.config import MAPS
from robot.calibration.adjustment import Adjustment, Weights
from robot.calibration.normal_equations import Equations
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import WheelMotion
from robot.fields.field_loading import load_field
from robot.mapping import map_adjustment
from robot.mapping.map_adjustment import DERIVATIVES, MapAdjustment
from robot.mapping.mapper import LOOSE_SD, Mapper

LONGEST_S = 300.0
"""Of a tour [s]."""


@pytest.mark.slow
def test_the_parts_of_a_drive_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn, _ = mapped("square", 60100)
    log, *_ = driven("default", 60100, 16.5, eight, "square", calibrated=True, steer=None)
    mapper = Mapper(log, SPEC, WIDTH)
    motion = WheelMotion.of(mapper._every, SPEC)
    seen = Sightings.of_edges(mapper._every, SPEC, mapper._nothing.edges)
    start = drawn.solution.state.poses[0]
    adjustment = MapAdjustment(seen, motion, drawn.measured, start, np.diag(LOOSE_SD**2))
    state = replace(drawn.solution.state, map=drawn.measured.offsets)
    count = len(state.poses)
    found = []
    for size in (count, 17):
        monkeypatch.setattr(map_adjustment, "AT_A_TIME", size)
        first = adjustment._equations(state, Weights(), None)
        second = adjustment._equations(state, Weights(), first.misses.pixels)
        found.append((second, *second.solve()))
    (whole, *steps), (parts, *others) = found
    assert parts.cost == pytest.approx(whole.cost, rel=1e-12)
    for step, other in zip(steps, others, strict=True):
        np.testing.assert_array_equal(step, other)
    assert len(whole.misses.residuals) > 10 * count
    for name in vars(whole.misses):
        np.testing.assert_array_equal(getattr(whole.misses, name), getattr(parts.misses, name))
    assert all(not len(getattr(parts.misses, name)) for name in DERIVATIVES)


@pytest.mark.slow
def test_an_adjustment_does_not_stand_still_where_tape_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Edges that passed the end of a stroke cost as much as any: it took 540 evaluations."""
    evaluated = []

    def counted(self: Adjustment, *given: Any) -> Equations:
        evaluated.append(self)
        return evaluate(self, *given)

    evaluate = Adjustment._equations
    monkeypatch.setattr(Adjustment, "_equations", counted)
    name = "generated-37206"
    taped = load_field(name, MAPS)
    mapped.cache_clear()
    drawn, poses = mapped(
        name, 81206, "hand-built", LONGEST_S, calibrate=True, steer=Tour(taped, 2)
    )
    assert len(evaluated) < 300
    assert drawn.fits
    errors = errors_of(drawn, poses, taped)
    assert errors.mean < 0.001
    assert errors.covered > 0.99
