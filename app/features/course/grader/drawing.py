"""Pictures of cases as SVG: what is due solid, what the code gives dashed."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from app.languages.catalogue import Catalogue
from app.languages.marking import phrase
from robot.geometry import Array

SIZE = 320.0
MARGIN = 34.0
STYLES = {
    "start": ("--quiet", "#55606b"),
    "due": ("--good", "#00795c"),
    "given": ("--odometry", "#c2440c"),
    "rays": ("--rays", "#a86200"),
    "tape": ("--text", "#14181d"),
}
"""Colours by role, as the page names them, with what holds outside of it."""
LABEL = re.compile(r"(?<=>)@([^<]+)(?=<)")
LABELS = {"due": phrase("due"), "given": phrase("your code"), "start": phrase("start")}


def translated(picture: str, language: Catalogue) -> str:
    """Return a picture with its labels in a language."""
    return LABEL.sub(lambda match: escape(language.t(match[1])), picture)


class Drawing:
    """Draws in metres, y up; what is drawn first decides the scale."""

    def __init__(self, points: Array) -> None:
        """Fit the drawing to points (n, 2) [m]; those that are not finite are left out."""
        seen = points[np.isfinite(points).all(axis=1)]
        low, high = (seen.min(axis=0), seen.max(axis=0)) if len(seen) else (np.zeros(2), np.ones(2))
        span = max(float((high - low).max()), 1e-3)
        self._scale = (SIZE - 2 * MARGIN) / span
        self._middle = (low + high) / 2
        self._parts: list[str] = []

    def __str__(self) -> str:
        """Return the SVG."""
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE:g} {SIZE:g}" role="img">'
        )
        return "".join([head, *self._parts, "</svg>"])

    def line(self, points: Array, style: str, *, width: float = 2) -> None:
        """Draw a line through points (n, 2)."""
        if len(points) and np.isfinite(points).all():
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self._place, points))
            stroke = f'stroke="{_colour(style)}" stroke-width="{width:g}"{_dashes(style)}'
            self._parts.append(f'<polyline points="{path}" fill="none" {stroke}/>')

    def dot(self, point: Array, style: str, radius: float = 3) -> None:
        """Draw a dot at a point (2,): filled, or hollow if it is what the code gives."""
        if np.isfinite(point).all():
            x, y = self._place(point)
            fill = "none" if style == "given" else _colour(style)
            ring = f'fill="{fill}" stroke="{_colour(style)}" stroke-width="1.5"'
            self._parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" {ring}/>')

    def arrow(self, pose: Array, style: str, label: str = "") -> None:
        """Draw a pose: x, y and the heading's cosine and sine; the label stands at its tip."""
        if not np.isfinite(pose).all():
            return
        length = 30 / self._scale
        tip = pose[:2] + length * pose[2:]
        side = np.array([-pose[3], pose[2]]) * length / 5
        barb = tip - pose[2:] * length / 3
        self.dot(pose[:2], style)
        self.line(np.array([pose[:2], tip]), style)
        self.line(np.array([barb + side, tip, barb - side]), style)
        self.text(tip, f"@{label}" if label else "", style)

    def text(self, point: Array, words: str, style: str) -> None:
        """Write beside a point; words that begin with @ are translated."""
        x, y = self._place(point)
        anchor = "end" if x > 0.7 * SIZE else "start"
        moved = -6 if anchor == "end" else 6
        place = f'x="{x + moved:.1f}" y="{y - 4:.1f}" text-anchor="{anchor}" font-size="13"'
        self._parts.append(f'<text {place} fill="{_colour(style)}">{escape(words)}</text>')

    def _place(self, point: Array) -> tuple[float, float]:
        x, y = (point - self._middle) * self._scale
        return float(np.clip(SIZE / 2 + x, -SIZE, 2 * SIZE)), float(
            np.clip(SIZE / 2 - y, -SIZE, 2 * SIZE)
        )


def draw_poses(poses: Mapping[str, Array], tape: Sequence[Array] = ()) -> str:
    """Draw poses (4,) as arrows, by style."""
    drawing = Drawing(np.array([pose[:2] for pose in poses.values()]))
    for line in tape:
        drawing.line(line, "tape", width=1)
    for style, pose in poses.items():
        drawing.arrow(pose, style, LABELS.get(style, style))
    return str(drawing)


def draw_clouds(clouds: Mapping[str, Array]) -> str:
    """Draw clouds of points (n, 2), by style."""
    drawing = Drawing(np.concatenate([cloud[:, :2] for cloud in clouds.values()]))
    for style, cloud in clouds.items():
        for point in cloud[:200]:
            drawing.dot(point[:2], style, 2)
    for style, cloud in clouds.items():
        drawing.text(np.max(cloud[:, :2], axis=0), f"@{LABELS.get(style, style)}", style)
    return str(drawing)


def draw_scan(poses: Array, ends: Array, tape: Array) -> str:
    """Draw tape (t, 4), poses (n, 4), and the first one's rays to their ends (k, 2)."""
    lines = tape.reshape(-1, 2, 2)
    drawing = Drawing(np.concatenate([lines.reshape(-1, 2), poses[:, :2], ends]))
    for line in lines:
        drawing.line(line, "tape", width=4)
    for end in ends:
        drawing.line(np.array([poses[0, :2], end]), "rays", width=1)
        if np.isfinite(end).all():
            drawing.dot(end, "rays")
    for pose in poses:
        drawing.arrow(pose, "start")
    return str(drawing)


def draw_bars(due: Array, given: Array, names: Sequence[str] = ()) -> str:
    """Draw values (n,) beside each other as bars: due solid, given hollow."""
    values = np.nan_to_num(np.concatenate([due, given, [0.0]]), posinf=0, neginf=0)
    low, high = float(values.min()), float(values.max())
    scale = (SIZE - 2 * MARGIN) / max(high - low, 1e-9)
    base, width = MARGIN + high * scale, (SIZE - 2 * MARGIN) / max(len(due), 1)
    parts = []
    for index, pair in enumerate(zip(due, given, strict=True)):
        for shift, (style, value) in enumerate(zip(("due", "given"), pair, strict=True)):
            if np.isfinite(value):
                x = MARGIN + width * (index + 0.45 * shift)
                top, height = base - max(value, 0) * scale, abs(value) * scale
                fill = "none" if style == "given" else _colour(style)
                box = f'x="{x:.1f}" y="{top:.1f}" width="{0.4 * width:.1f}" height="{height:.1f}"'
                ring = f'stroke="{_colour(style)}"{_dashes(style)}'
                parts.append(f'<rect {box} fill="{fill}" {ring}/>')
        if index < len(names):
            x, y = MARGIN + width * (index + 0.4), SIZE - 10
            place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="middle" font-size="12"'
            parts.append(f'<text {place} fill="currentColor">{escape(names[index])}</text>')
    axis = f'<path d="M{MARGIN:g} {base:.1f}H{SIZE - MARGIN:g}" stroke="currentColor"/>'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIZE:g} {SIZE:g}" role="img">'
    return "".join([head, *parts, axis, "</svg>"])


def _colour(style: str) -> str:
    return f"var({', '.join(STYLES[style])})"


def _dashes(style: str) -> str:
    return ' stroke-dasharray="5 3"' if style == "given" else ""
