"""Lesson 2: ``project(u, v, camera)`` gives bearing and range of the floor point of a pixel."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from types import SimpleNamespace

import numpy as np

from app.features.course.grader.case import (
    Case,
    Checks,
    Hypothesis,
    Outcome,
    Sign,
    by_mistake,
)
from app.features.course.grader.drawing import draw_poses
from app.features.course.grader.forms import array_of
from app.features.course.grader.words import Words
from robot.geometry import Array

CAMERA = SimpleNamespace(focal=300.0, u0=160.0, v0=120.0, height=0.15, tilt=30.0, forward=0.06)
PIXELS = (
    ("middle", "The pixel in the middle of the picture.", 0.0, 0.0),
    ("row", "A pixel {across} to the right of the middle.", 90.0, 0.0),
    ("row", "A pixel {across} to the left of the middle.", -70.0, 0.0),
    ("column", "A pixel {along} below the middle.", 0.0, 80.0),
    ("column", "A pixel {along} above the middle.", 0.0, -50.0),
    ("corner", "A pixel {across} to the left and {along} below the middle.", -110.0, 60.0),
    ("sky", "A pixel above the horizon, {along} above the middle.", 30.0, -200.0),
)
TOLERANCE = np.array([1e-7, 1e-7])
SHOWN_M = 2.0
"""Points farther away are drawn here."""
FAR = np.array([0.0, math.inf])
"""What is due above the horizon: no bearing counts there."""
NOT_FALLEN = ("by-length", "by-length-ahead", "by-ahead", "by-row")
OFFSETS, TILTS = (
    frozenset(["no-offset", "backwards", "offset-late"]),
    frozenset(["tilt-in-degrees", "tilt-to-degrees", "tilted-up", "level", "from-below"]),
)


def cases(seed: int) -> list[Case]:
    """Each pixel with the usual camera, then with cameras by the seed."""
    rng = np.random.default_rng(seed)
    made = [_case(pixel, CAMERA) for pixel in PIXELS]
    for pixel in PIXELS:
        camera = SimpleNamespace(
            focal=float(rng.uniform(200, 600)),
            u0=float(rng.uniform(100, 300)),
            v0=float(rng.uniform(100, 200)),
            height=float(rng.uniform(0.08, 0.3)),
            tilt=float(rng.uniform(20, 25 if pixel[0] == "sky" else 60)),
            forward=float(rng.uniform(0.02, 0.12)),
        )
        kind, text, right, down = pixel
        scale = camera.focal / CAMERA.focal
        made.append(_case((kind, text, round(right * scale, 1), round(down * scale, 1)), camera))
    return made


def _case(pixel: tuple[str, str, float, float], camera: SimpleNamespace) -> Case:
    kind, text, right, down = pixel
    values = {
        "pixel": Words(text, {"across": f"{abs(right):g} px", "along": f"{abs(down):g} px"}),
        "height": round(1000 * camera.height),
        "tilt": round(camera.tilt, 1),
        "forward": round(1000 * camera.forward),
    }
    words = Words(
        "{pixel} The camera is {height} mm high, tilted {tilt}° down, {forward} mm ahead of the "
        "axle.",
        values,
    )
    arguments = (camera.u0 + right, camera.v0 + down, camera)
    return Case("project", arguments, words, kind, TOLERANCE)


def features(outcome: Outcome) -> Array:
    """Bearing and range; where the range is infinite, the bearing does not count."""
    values = array_of(outcome.result, (2,), finite=False)
    return FAR if values[1] == math.inf else values + 0.0


def expected(case: Case, mistakes: frozenset[str]) -> Array:
    """Bearing and range that formulas with mistakes give."""
    u, v, camera = case.arguments
    right, down = _on_plane(u, v, camera, mistakes)
    c, s = _turned(camera.tilt, mistakes)
    fall = s - c * down if "fall-sign" in mistakes else s + c * down
    if "horizon-early" in mistakes and v < camera.v0:
        return FAR
    if "horizon-middle" in mistakes and v <= camera.v0:
        return FAR
    if abs(fall) < 1e-12 or (fall < 0 and "horizon" not in mistakes):
        return FAR[::-1] if "exchanged-always" in mistakes else FAR
    scale = (1.0 if "height-lost" in mistakes else camera.height) / fall
    ahead = c + s * down if "turned-back" in mistakes else c - s * down
    parts = {
        "by-length": math.hypot(ahead, fall, right),
        "by-length-ahead": math.hypot(ahead, fall),
        "by-ahead": ahead,
        "by-row": down,
    }
    part = by_mistake(mistakes, parts, fall)
    scale = by_mistake(mistakes, dict.fromkeys(parts, camera.height / (part or math.nan)), scale)
    if "offset-early" in mistakes:
        ahead += camera.forward - camera.forward / scale
    sides = {"side-short": -right, "side-along-floor": -scale * ahead * right}
    side = by_mistake(mistakes, sides, -scale * right)
    side = -side if "mirrored" in mistakes else side
    return _bearing_and_range(scale * ahead, side, right, camera, mistakes)


def _turned(tilt: float, mistakes: frozenset[str]) -> tuple[float, float]:
    """Return cosine and sine of how far the camera looks down."""
    down = math.radians(tilt)
    tilts = {
        "tilt-in-degrees": tilt,
        "tilt-to-degrees": math.degrees(tilt),
        "tilted-up": -down,
        "level": 0.0,
        "from-below": math.pi / 2 - down,
    }
    down = by_mistake(mistakes, tilts, down)
    return math.cos(down), math.sin(down)


def _bearing_and_range(
    ahead: float, y: float, right: float, camera: SimpleNamespace, mistakes: frozenset[str]
) -> Array:
    """Return what is told of a point that lies ahead of the camera, and y to the left."""
    x = ahead + by_mistake(
        mistakes, {"no-offset": 0.0, "backwards": -camera.forward}, camera.forward
    )
    if "cartesian" in mistakes:
        return np.array([x, y])
    if "offset-late" in mistakes:
        x -= camera.forward
    bearings = {
        "from-camera": math.atan2(y, ahead),
        "bearing-in-picture": -math.atan(right),
        "from-angles": -math.atan(right),
        "no-arctan": y / x if x else math.inf,
        "swapped": math.atan2(x, y),
    }
    bearing = by_mistake(mistakes, bearings, math.atan2(y, x))
    if "bearing-left" in mistakes:
        bearing = abs(bearing)
    if "bearing-right" in mistakes:
        bearing = -abs(bearing)
    if "bearing-in-degrees" in mistakes:
        bearing = math.degrees(bearing)
    slant = camera.height if "slanted" in mistakes else 0.0
    ranges = {
        "only-ahead": x,
        "no-root": x * x + y * y,
        "slanted-from-camera": math.sqrt(ahead * ahead + y * y + camera.height**2),
        "range-from-camera": math.hypot(ahead, y),
        "range-ahead-of-camera": ahead,
        "from-angles": x * math.hypot(1.0, right),
        "offset-late": math.hypot(x, y) + camera.forward,
    }
    far = by_mistake(mistakes, ranges, math.sqrt(x * x + y * y + slant * slant))
    if mistakes & {"exchanged", "exchanged-always"}:
        bearing, far = far, bearing
    return np.array([bearing, far]) + 0.0


def _on_plane(
    u: float, v: float, camera: SimpleNamespace, mistakes: frozenset[str]
) -> tuple[float, float]:
    """Return how far right and down the ray is, one unit ahead of the lens."""
    u0, v0 = (0.0, 0.0) if "corner" in mistakes else (camera.u0, camera.v0)
    focal = 1.0 if "no-focal-length" in mistakes else camera.focal
    if "axes-exchanged" in mistakes:
        u, v = v, u
    if "middles-exchanged" in mistakes:
        u0, v0 = v0, u0
    right = (u - u0) / (1.0 if "focal-v-alone" in mistakes else focal)
    down = (v - v0) / (1.0 if "focal-u-alone" in mistakes else focal)
    if "pixels-as-angles" in mistakes:
        right, down = math.tan(right), math.tan(down)
    if "rows-as-angles" in mistakes:
        down = math.tan(down)
    return right, -down if "upside-down" in mistakes else down


def signs(outcomes: Sequence[Outcome]) -> Iterator[Sign]:
    """What shows by itself: the sky's range; the offset, by which ranges ahead are short."""
    wrong = [item for item in outcomes if not np.allclose(features(item), _due(item), atol=1e-7)]
    if wrong and all(item.case.kind == "sky" for item in wrong):
        yield Sign("sky", wrong[0])
        return
    for outcome in outcomes:
        _, _, camera = outcome.case.arguments
        if outcome.case.kind in ("middle", "column"):
            far = features(outcome)[1]
            due = expected(outcome.case, frozenset())[1]
            if abs(far - due + camera.forward) < 1e-6:
                yield Sign("S9", outcome)
                return
    lost = _rows_or_columns_lost(outcomes)
    if wrong and lost:
        yield Sign(lost, wrong[0], weak=True)
    elif wrong:
        bearing, far = np.abs(features(wrong[0]) - _due(wrong[0])) < TOLERANCE
        yield Sign("range" if bearing else "bearing" if far else "point", wrong[0], weak=True)


def _rows_or_columns_lost(outcomes: Sequence[Outcome]) -> str:
    """Return the cause if pixels that lie apart are told as the same point; "" if they are not."""
    middle = next((features(item) for item in outcomes if item.case.kind == "middle"), None)
    if middle is None:
        return ""
    for kind, cause in (("column", "rows-lost"), ("row", "columns-lost")):
        points = [
            features(item)
            for item in outcomes
            if item.case.kind == kind and item.case.arguments[2] is CAMERA
        ]
        if points and all(np.allclose(each, middle, atol=1e-7) for each in points):
            return cause
    return ""


def _due(outcome: Outcome) -> Array:
    return expected(outcome.case, frozenset())


def show(_case: Case, values: Array) -> str:
    """Return bearing and range in words."""
    if math.isinf(values[1]):
        return "∞"
    return f"{math.degrees(values[0]):.2f}°, {1000 * values[1]:.1f} mm"


def picture(outcome: Outcome, due: Array, given: Array) -> str:
    """Draw robot, camera, and both points on the floor."""
    _, _, camera = outcome.case.arguments
    shown = {"start": np.array([0.0, 0.0, 1.0, 0.0])}
    for style, (bearing, far) in (("due", due), ("given", given)):
        if not math.isfinite(bearing):
            continue  # it points nowhere
        toward = np.array([math.cos(bearing), math.sin(bearing)])
        shown[style] = np.concatenate([min(far, SHOWN_M) * toward, toward])
    return draw_poses(shown, [np.array([[camera.forward, -0.03], [camera.forward, 0.03]])])


CHECKS = Checks(
    functions=("project",),
    cases=cases,
    features=features,
    expected=expected,
    hypotheses=(
        Hypothesis("no-offset", "S9", OFFSETS),
        Hypothesis("backwards", "offset-sign", OFFSETS),
        Hypothesis("tilt-in-degrees", "S4", TILTS),
        Hypothesis("tilt-to-degrees", "S4", TILTS),
        Hypothesis("bearing-in-degrees", "S4"),
        Hypothesis("mirrored", "left-right"),
        Hypothesis("bearing-left", "one-side"),
        Hypothesis("bearing-right", "one-side"),
        Hypothesis("upside-down", "up-down"),
        Hypothesis("horizon", "horizon"),
        Hypothesis("slanted", "slant"),
        Hypothesis("tilted-up", "tilt", TILTS),
        Hypothesis("level", "tilt", TILTS),
        Hypothesis("from-below", "tilt", TILTS),
        Hypothesis("corner", "pixel-origin"),
        Hypothesis("no-focal-length", "focal"),
        Hypothesis("swapped", "arctan"),
        Hypothesis("only-ahead", "slant"),
        Hypothesis("offset-late", "offset-late", OFFSETS),
        Hypothesis("offset-early", "offset-early", OFFSETS),
        Hypothesis("turned-back", "rotation"),
        Hypothesis("side-short", "side"),
        Hypothesis("horizon-early", "horizon-early", frozenset(["horizon"])),
        Hypothesis("exchanged", "exchanged"),
        Hypothesis("exchanged-always", "exchanged"),
        Hypothesis("cartesian", "cartesian"),
        Hypothesis("horizon-middle", "horizon-early", frozenset(["horizon"])),
        Hypothesis("fall-sign", "rotation"),
        Hypothesis("height-lost", "height-lost"),
        *(Hypothesis(name, "not-fallen") for name in NOT_FALLEN),
        Hypothesis("side-along-floor", "side"),
        Hypothesis("from-camera", "from-camera"),
        Hypothesis("range-from-camera", "from-camera"),
        Hypothesis("range-ahead-of-camera", "slant"),
        Hypothesis("slanted-from-camera", "slant"),
        Hypothesis("bearing-in-picture", "bearing-in-picture"),
        Hypothesis("from-angles", "bearing-in-picture"),
        Hypothesis("no-arctan", "no-arctan"),
        Hypothesis("no-root", "no-root"),
        Hypothesis("axes-exchanged", "pixel-axes"),
        Hypothesis("middles-exchanged", "pixel-axes"),
        Hypothesis("focal-v-alone", "focal"),
        Hypothesis("focal-u-alone", "focal"),
        Hypothesis("pixels-as-angles", "pixels-as-angles"),
        Hypothesis("rows-as-angles", "pixels-as-angles"),
    ),
    signs=signs,
    show=show,
    picture=picture,
)
