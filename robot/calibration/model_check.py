"""Checks what a calibration takes for granted: the tape's width, the drawing, and the lens file.

A wrong drawing or lens does not show in the residual: camera and path give way until nearly all of
it is gone. So each is asked for as one more unknown, which is solved for with all others free, but
one at a time (data snooping; Baarda 1968). What comes out far from zero is said. Nothing else is
changed by it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.calibration.adjustment import (
    UNSETTLED,
    Adjustment,
    CalibrationError,
    Solution,
    Weights,
    residual_sd,
)
from robot.calibration.misses import Misses
from robot.camera import Lens
from robot.description.unknowns import TAPE
from robot.fields.edges import lengths
from robot.fields.field import Field
from robot.geometry import Array

LEAST_WIDTH, LEAST_OFFSET, LEAST_BENT = 0.0003, 0.0012, 0.7
"""Least errors that are reported: of the tape's width [m], of a stroke's place [m], and of how the
lens bends rays to the picture's corners [px]."""
SURE = 6.0
"""... if they are at least this many standard deviations."""
EQUAL = 0.8
"""Strokes are named together if they explain the misses nearly as well: at this share of the
deviations. Of four sides that form no square, nobody can tell which one is at the wrong place."""
FAR_OFF = 1.1
"""Edges are reported if they lie this many times as far off as expected; half of it is usual."""
LEAST_LENGTH = 0.1
"""Shorter edges are not looked at [m]."""
ALIKE = 0.02
"""Largest sine of the angle between edges of a stroke."""
WIDER = 1.2
"""Edges of a stroke are at most this many times as far apart as the tape is wide."""


def remarks(
    adjustment: Adjustment, solution: Solution, weights: Weights, taped: Field, lens: Lens
) -> tuple[str, ...]:
    """Return what seems to be wrong with the field or the lens file, in words for people.

    Args:
        adjustment: of a drive.
        solution: what it found ...
        weights: ... with these.
        taped: the field as drawn, of tape.
        lens: as described.

    Raises:
        CalibrationError: a piece of tape would lie beside the field: what was found fits nothing.
    """
    seen = solution.misses
    strokes = strokes_of(taped)

    def by_others(misses: Misses) -> Array:
        offsets = (by_offset(misses, taped, stroke) for stroke in strokes)
        return np.column_stack([*offsets, by_bending(misses, lens)])

    values, sd = adjustment.alone(solution, weights, by_others)
    words = [_of_width(solution, taped), _of_strokes(values[:-1], sd[:-1], strokes, taped)]
    if abs(values[-1]) > max(LEAST_BENT, SURE * sd[-1]):
        words.append(
            f"the lens file does not fit: in the picture's corners it is {abs(values[-1]):.1f} px "
            "off; measure the lens by brickpose calibrate lens"
        )
    elif residual_sd(seen) > FAR_OFF:
        words.append(
            f"the edges lie {residual_sd(seen):.1f} times as far off as expected: the lens file or "
            "the drawing of the field does not fit"
        )
    return tuple(remark for remark in words if remark)


def _of_width(solution: Solution, taped: Field) -> str:
    assert taped.tape_width is not None
    wider, sd = solution.state.values[TAPE], np.sqrt(solution.covariance[TAPE, TAPE])
    if abs(wider) < max(LEAST_WIDTH, SURE * sd):
        return ""
    seems, drawn = 1e3 * (taped.tape_width + wider), 1e3 * taped.tape_width
    return f"the tape seems to be {seems:.1f} mm wide, not {drawn:.1f} mm"


def _of_strokes(offsets: Array, sd: Array, strokes: list[NDArray[np.int64]], taped: Field) -> str:
    sure = np.abs(offsets) / sd
    sure[np.abs(offsets) < LEAST_OFFSET] = 0
    if sure.max(initial=0.0) < SURE:
        return ""
    guilty = np.flatnonzero(sure >= EQUAL * sure.max())
    places = [
        "({:.2f}, {:.2f})".format(
            *(taped.edges[strokes[place]].reshape(-1, 2).mean(0).round(2) + 0)
        )
        for place in guilty[np.argsort(-sure[guilty])]
    ]
    left, bottom, right, top = taped.extent
    if np.abs(offsets[guilty]).max() > max(right - left, top - bottom):
        raise CalibrationError(UNSETTLED)
    distance = 1e3 * np.abs(offsets[guilty]).mean()
    return (
        f"the tape around {' or '.join(places)} m lies {distance:.1f} mm beside its drawing: "
        "measure the field"
    )


def strokes_of(taped: Field) -> list[NDArray[np.int64]]:
    """Return the edges of each straight stroke of tape."""
    long = np.flatnonzero(lengths(taped.edges) >= LEAST_LENGTH)
    strokes: list[NDArray[np.int64]] = []
    left = set(long.tolist())
    while left:
        stroke, border = [], [left.pop()]
        while border:
            edge = border.pop()
            stroke.append(edge)
            near = {other for other in left if _of_one_stroke(taped, edge, other)}
            left -= near
            border += near
        strokes.append(np.array(sorted(stroke)))
    return sorted(strokes, key=lambda stroke: int(stroke[0]))


def _of_one_stroke(taped: Field, a: int, b: int) -> bool:
    """Whether two edges are the sides of one stroke, opposite to each other."""
    assert taped.tape_width is not None
    normal, other = taped.normals[a], taped.normals[b]
    if normal @ other > 0 or abs(normal[0] * other[1] - normal[1] * other[0]) > ALIKE:
        return False
    start, end = taped.edges[a, :2], taped.edges[a, 2:]
    away = normal @ (start - taped.edges[b].reshape(2, 2).mean(axis=0))
    along = (end - start) / np.hypot(*(end - start))
    spans = [np.sort((edge.reshape(2, 2) - start) @ along) for edge in taped.edges[[a, b]]]
    overlap = min(span[1] for span in spans) - max(span[0] for span in spans)
    return bool(0 < away < WIDER * taped.tape_width and overlap > 0)


def by_offset(seen: Misses, taped: Field, stroke: NDArray[np.int64]) -> Array:
    """Return the derivatives of the misses (n,) by how far a stroke lies beside its drawing."""
    across: Array = seen.by_pose[:, :2] @ taped.normals[stroke[0]]
    return -np.where(np.isin(seen.edge, stroke), across, 0.0)


def by_bending(seen: Misses, lens: Lens) -> Array:
    """Return the derivatives of the misses (n,) by how far rays to the picture's corners are bent.

    It grows as the cube of the distance from the middle, as of a lens's first coefficient.
    """
    from_middle = (seen.seen_at - lens.matrix[:2, 2]) / np.hypot(lens.width / 2, lens.height / 2)
    bent = from_middle * np.square(from_middle).sum(axis=1, keepdims=True)
    result: Array = (seen.by_pixel * bent).sum(axis=1)
    return result
