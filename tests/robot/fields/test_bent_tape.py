"""Bent tape is seen from both sides, and what lies about on the floor is no bend."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from tape_trials import SCANNER, SQUARE, STILL, VIEW, camera_of, expected, trial

from robot.fields.field import Field
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2
from robot.interface import Frame
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from sim.floor_camera import CameraSettings, FloorCamera

pytestmark = pytest.mark.slow

WIDTH = 0.05
FROM_END = 0.06
"""So close to its ends tape may be missed [m]."""
STRAIGHT = LineScanner(VIEW, LineScannerSettings(bend_radius=1000.0))


@cache
def arc(radius: float) -> Field:
    """Tape along three quarters of a circle around (0, 0), open toward -x; radius by its middle."""
    r = 1000 * radius
    x = -r * math.sqrt(0.5)
    return field_of_drawing(
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="2000mm" '
        'viewBox="-1000 -1000 2000 2000"><rect x="-1000" y="-1000" width="2000" height="2000" '
        f'fill="#d7d5cf"/><path d="M {x} {-x} A {r} {r} 0 1 0 {x} {x}" fill="none" '
        'stroke="#202225" stroke-width="50"/></svg>',
        f"arc{radius}",
    )


def seen(radius: float, outside: bool, count: int = 25) -> tuple[int, int, float]:
    """Rays that cross the bend in sight, those of them that return it, and how far these are off.

    Which edge of the tape is met first says from which side it is seen.
    """
    field = arc(radius)
    camera, rng = camera_of(field), np.random.default_rng(0)
    near, far = SCANNER.table.limits.T
    due, found, errors = 0, 0, []
    for _ in range(count):
        # Looking at the tape from 0.25 to 0.5 m away: across the opening, or from beyond.
        turn = rng.uniform(-1.5, 1.5) if outside else rng.uniform(-0.4, 0.4)
        away = rng.uniform(0.25, 0.5)
        place = radius + away if outside else radius - away
        heading = turn + (math.pi if outside else 0.0) + rng.normal(0, 0.1)
        robot = Pose2(place * math.cos(turn), place * math.sin(turn), heading)
        scan = SCANNER.scan(Frame(0.0, camera.picture(robot, STILL))).scan
        begins, ends = expected(field, robot)
        bearings = SCANNER.table.bearings + robot.theta
        reach = np.nan_to_num(begins, posinf=9.0)
        x = robot.x + reach * np.cos(bearings)
        y = robot.y + reach * np.sin(bearings)
        from_end = radius * (0.75 * math.pi - np.abs(np.arctan2(y, x)))
        with np.errstate(invalid="ignore"):
            in_sight = (begins > near + 0.015) & (ends < far - 0.06)
            aslant = ends - begins >= 2 * WIDTH
            off = np.abs(scan.ranges - begins)
        side = (np.hypot(x, y) > radius) == outside
        crossed = in_sight & side & (from_end > FROM_END) & ~aslant
        due += int(crossed.sum())
        found += int((crossed & (off < 0.005)).sum())
        errors.extend(off[crossed & scan.hit])
    return due, found, float(np.median(errors))


@pytest.mark.parametrize("radius", [0.1, 0.15, 0.4])
@pytest.mark.parametrize("outside", [True, False], ids=["from outside", "from inside"])
def test_bent_tape_is_seen(radius: float, outside: bool) -> None:
    due, found, off = seen(radius, outside)
    assert due > 400
    assert found >= 0.95 * due
    assert off < 0.0001


def test_of_a_bend_that_is_too_tight_for_tape_little_is_believed() -> None:
    """Of radius 40 mm outside: the limit is 70."""
    due, found, _ = seen(0.04, True)
    assert due > 100 and found < 0.5 * due


@pytest.mark.parametrize("kind", ["all", "cable"])
def test_things_on_the_floor_are_hardly_more_often_taken_for_bends_than_for_lines(
    kind: str,
) -> None:
    shares = []
    for scanner in (STRAIGHT, SCANNER):
        hit = bad = 0
        for seed in range(3):
            rng = np.random.default_rng(seed)
            camera = FloorCamera(VIEW, SQUARE.floor, CameraSettings(clutter=kind), rng)
            found = trial(SQUARE, camera, scanner, count=12, seed=seed)
            hit, bad = hit + int(found.hit.sum()), bad + round(found.false * found.hit.sum())
        assert hit > 1200
        shares.append(bad / hit)
    straight, bent = shares
    assert bent <= straight + 0.02
