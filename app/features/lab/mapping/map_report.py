"""The report of a map: its strokes, the path, what was seen, and how certain all of it is."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from app.features.lab.report_page import BLUE, GREY, RED, page, svg_figure
from robot.mapping.tape_map import TapeMap

TEMPLATE = "map.html.jinja"
MOST_POINTS = 6000
"""Points that are drawn, of the edges that were seen."""


def map_report(drawn: TapeMap, source: str) -> str:
    """Return the report as HTML, with all figures in it."""
    solution = drawn.solution
    return page(
        TEMPLATE,
        source=source,
        fits=drawn.fits,
        remarks=drawn.remarks,
        strokes=len(drawn.tidy.strokes),
        corners=len(drawn.tidy.corners),
        length=drawn.length,
        seconds=drawn.stamps[-1] - drawn.stamps[0],
        share=drawn.share,
        facts=drawn.quality.facts,
        sd=float(np.median(drawn.node_sd)),
        largest_sd=float(drawn.node_sd.max()),
        slip=float(np.abs(solution.state.slip).max()),
        map=_draw(drawn),
    )


@svg_figure(6.4, 6.4)
def _draw(figure: Figure, drawn: TapeMap) -> None:
    axes = figure.add_subplot()
    seen = drawn.solution.misses.ends
    some = seen[:: max(1, len(seen) // MOST_POINTS)]
    axes.plot(*some.T, ".", color=GREY, markersize=1, label="edges that were seen", zorder=1)
    for number, stroke in enumerate(drawn.tidy.strokes):
        label = "centre lines of tape" if number == 0 else None
        axes.plot(*stroke.points.T, color="black", linewidth=1.2, label=label, zorder=3)
    poses = drawn.solution.state.poses
    axes.plot(*poses[:, :2].T, color=BLUE, linewidth=0.8, label="path", zorder=2)
    unseen = drawn.unseen_ends
    if len(unseen):
        axes.plot(*unseen.T, "o", color=RED, mfc="none", label="ends that nobody saw")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    figure.legend(loc="outside lower center", ncols=4, markerscale=2)
