"""Draw the map with the robot's paths by the filter and by odometry."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.localized import LONGEST_GAP, Localized, ReportedPose
from app.features.lab.report_page import BLUE, PURPLE, STROKES, STYLE
from robot.geometry import Array, Pose2, compose

INCHES, DPI = 9.0, 150
MARGIN = 3.0
"""Margin of map that is shown around the paths [m]."""
WIDER = 0.6
"""Smallest ratio of the picture's shorter side to its longer side."""


def draw(path: Path, localized: Localized, laser_map: LaserMap) -> None:
    """Write a PNG.

    Args:
        localized: the filter's result; if it never was certain, its places at the end are shown.

    Raises:
        OSError: the file cannot be written.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(INCHES, INCHES), layout="constrained")
        axes = figure.add_subplot()
        _floor(axes, laser_map)
        shown = _ways(axes, localized) if localized.reports else _places(axes, localized)
        _look_at(axes, shown, laser_map)
        axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        handles, labels = axes.get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        axes.legend(unique.values(), unique.keys(), loc="upper right", frameon=True, fontsize=8)
        figure.savefig(path, dpi=DPI, metadata={"Software": None})


def _floor(axes: Axes, laser_map: LaserMap) -> None:
    height, width = laser_map.grid.data.shape
    side, pose = laser_map.grid.resolution, laser_map.map_from_cells
    tones = np.full(laser_map.grid.data.shape, 205, dtype=np.uint8)
    tones[laser_map.grid.free], tones[laser_map.grid.occupied] = 255, 90
    turn = mpl.transforms.Affine2D().rotate(pose.theta).translate(pose.x, pose.y)
    axes.imshow(
        tones, cmap="gray", vmin=0, vmax=255, origin="lower", interpolation="nearest",
        extent=(0, width * side, 0, height * side), transform=turn + axes.transData,
    )  # fmt: skip


def _ways(axes: Axes, localized: Localized) -> Array:
    """Draw estimate and odometry, which begin together; return the points to show (n, 2)."""
    standing, shown = localized.standing, []
    if standing:
        poses = np.array([pose_report.pose for pose_report in standing])
        odometry = np.array([each.odometry for each in standing])
        begin = Pose2.from_array(poses[0]) @ Pose2.from_array(odometry[0]).inverse()
        alone = compose(np.tile(begin.to_array(), (len(odometry), 1)), odometry)
        for way, stroke in ((alone, STROKES["odometry"]), (_broken(standing), STROKES["amcl"])):
            stroke.draw(axes, way)
        for pose, mark, label in ((poses[0], "o", "first known"), (poses[-1], "X", "end")):
            axes.plot(*pose[:2], mark, color=BLUE, ms=7, mec="white", label=label)
        shown.append(poses[:, :2])
    if withdrawn := localized.withdrawn:
        way = _broken(withdrawn)
        axes.plot(way[:, 0], way[:, 1], ":", color=PURPLE, lw=1.6, label="told, and withdrawn")
        shown.append(np.array([item.pose[:2] for item in withdrawn]))
    return np.concatenate(shown)


def _broken(tolds: Sequence[ReportedPose]) -> Array:
    """Return the poses (n, 3), with nan where no pose was reported for some time."""
    rows = []
    for before, item in zip([tolds[0], *tolds], tolds, strict=False):
        if item.stamp - before.stamp > LONGEST_GAP:
            rows.append(np.full(3, np.nan))
        rows.append(item.pose)
    return np.array(rows)


def _places(axes: Axes, localized: Localized) -> Array:
    """Draw the places where the robot may be at the end; return their centres (n, 2).

    They are circles of two standard deviations.
    """
    places = localized.final.hypotheses if localized.final else ()
    centres = np.array([[item.pose.x, item.pose.y] for item in places]).reshape(-1, 2)
    for place, (x, y) in zip(places, centres, strict=True):
        wide = 2 * float(np.sqrt(np.trace(place.covariance[:2, :2]) / 2))
        axes.add_patch(Circle((x, y), wide, fill=False, color=BLUE, label="may be here"))
    return centres


def _look_at(axes: Axes, places: Array, laser_map: LaserMap) -> None:
    """Show the points and some of the map around them; the whole map if there are none."""
    if not len(places):
        height, width = laser_map.grid.data.shape
        corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float64)
        places = laser_map.map_from_cells.apply(corners * laser_map.grid.resolution)
    low, high = places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN
    middle, half = (low + high) / 2, (high - low) / 2
    half = np.maximum(half, WIDER * half.max())
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
