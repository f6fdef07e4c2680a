"""The report of a lens: what it is, how sure that is, and by which pictures."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from scipy.spatial import ConvexHull

from app.features.lab.report_page import BLUE, RED, page, picture_frame, svg_figure
from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import COLUMNS, LEAST_CORNERS, ROWS, missing, parts_seen, tilt
from robot.calibration.lens.lens_calibration import LensCalibration

TEMPLATE = "lens.html.jinja"
LENGTHENED = 100.0
"""Errors are drawn this many times as long."""


def lens_report(result: LensCalibration, board: Board) -> str:
    """Return the report as HTML, with all figures in it."""
    chosen = result.chosen
    sd = result.sd
    names = result.lens.parameters.items()
    rows = [
        (name, value, 1.96 * error) for (name, value), error in zip(names, sd.tolist(), strict=True)
    ]
    return page(
        TEMPLATE,
        lens=result.lens,
        board=board.words,
        chosen=chosen,
        ratings=result.ratings,
        parameters=rows,
        pictures=_pictures(result, board),
        refused=sorted(result.refused.items()),
        missing=[*result.quality.remarks, *missing(list(result.seen.values()), board)],
        facts=result.quality.facts,
        residuals=residual_picture(result),
        coverage=coverage_picture(result),
        lengthened=LENGTHENED,
    )


@svg_figure(6.4, 5.0)
def residual_picture(figure: Figure, result: LensCalibration) -> None:
    """Draw how far corners lie off, over the picture, as SVG."""
    axes = picture_frame(figure, result.lens)
    places = np.concatenate([sighting.pixels for sighting in result.seen.values()])
    errors = np.concatenate(result.chosen.fit.errors)
    axes.quiver(
        *places.T, *errors.T, angles="xy", scale_units="xy", scale=1 / LENGTHENED,
        width=0.0015, color=BLUE,
    )  # fmt: skip
    axes.set_title(f"errors of corners, {LENGTHENED:g} times as long")


@svg_figure(6.4, 5.0)
def coverage_picture(figure: Figure, result: LensCalibration) -> None:
    """Draw where in the picture the boards were, as SVG; parts without one are shaded."""
    axes = picture_frame(figure, result.lens)
    width, height = result.lens.width / COLUMNS, result.lens.height / ROWS
    for row, column in np.argwhere(parts_seen(list(result.seen.values())) < LEAST_CORNERS):
        corner = column * width, row * height
        axes.add_patch(Rectangle(corner, width, height, color=RED, alpha=0.25, lw=0))
    for sighting in result.seen.values():
        hull = sighting.pixels[ConvexHull(sighting.pixels).vertices]
        axes.fill(*hull.T, facecolor=BLUE, alpha=0.06)
        axes.plot(*np.vstack([hull, hull[:1]]).T, color=BLUE, lw=0.7)
        axes.plot(*sighting.pixels.T, ".", color=BLUE, ms=2)
    axes.set_title("where the boards were; shaded: nothing yet")


def _pictures(result: LensCalibration, board: Board) -> list[dict[str, object]]:
    held_out = np.sqrt(result.chosen.held_out).tolist()
    rows = []
    for (name, sighting), error in zip(result.seen.items(), held_out, strict=True):
        angle, side = tilt(sighting, board)
        rows.append(
            {
                "name": name,
                "error": error,
                "corners": len(sighting.ids),
                "edge": sighting.edge_width,
                "tilt": f"{math.degrees(angle):.0f} degrees, {side} side far",
            }
        )
    return rows
