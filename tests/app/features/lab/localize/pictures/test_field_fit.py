"""The share of seen edges that lie on the field's."""

import math

import numpy as np
import pytest

from app.features.lab.localize.pictures.field_fit import FEWEST, WINDOW_S, FieldFit
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2
from robot.localization.estimate import Integrity, State
from robot.scan import Scan

STRIPE = """<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="2000mm"
 viewBox="-1000 -1000 2000 2000" data-start="0 0 0"><rect x="-1000" y="-1000" width="2000"
 height="2000" fill="#fff"/><path d="M500,-900 V900" stroke="#000" stroke-width="50"/></svg>"""
BEARINGS = np.linspace(-0.5, 0.5, 40)
CERTAIN = Integrity(State.CERTAIN, 0.01, 0.01)


def seen(stamp: float) -> Scan:
    """The stripe's nearer edge, seen from the field's middle."""
    return Scan(stamp, BEARINGS, 0.475 / np.cos(BEARINGS))


def fit() -> FieldFit:
    return FieldFit(field_of_drawing(STRIPE, "stripe"))


def test_edges_where_they_are_drawn_leave_the_claim_and_others_take_it() -> None:
    right, wrong, behind = fit(), fit(), fit()
    for k in range(FEWEST):
        right.observe(seen(0.1 * k), Pose2())
        wrong.observe(seen(0.1 * k), Pose2(x=-0.2))
        # There the stripe's other edge lies, which a ray leaves tape by.
        behind.observe(seen(0.1 * k), Pose2(x=0.05))
    assert right.share == 1.0
    assert right.judged(CERTAIN) is CERTAIN
    for each in (wrong, behind):
        assert each.share == 0.0
        assert each.judged(CERTAIN).state is State.LOST
        assert each.judged(CERTAIN).radius == math.inf


def test_before_enough_pictures_nothing_is_certain() -> None:
    early = fit()
    early.observe(seen(0.0), Pose2())
    assert early.judged(CERTAIN).state is State.APPROXIMATE
    assert early.judged(CERTAIN).radius == CERTAIN.radius


def test_pictures_without_edges_say_nothing_and_old_ones_no_more() -> None:
    of_all = fit()
    nothing = Scan(0.0, BEARINGS, np.full(40, np.inf))
    for _ in range(9):
        of_all.observe(nothing, Pose2())
    assert math.isnan(of_all.share)
    for k in range(FEWEST):
        of_all.observe(seen(0.1 * k), Pose2(x=-0.2))
    for k in range(FEWEST):
        of_all.observe(seen(2 * WINDOW_S + 0.1 * k), Pose2())
    assert of_all.share == pytest.approx(1.0)
