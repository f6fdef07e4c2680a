"""Panels of features, as sections of the page that their own scripts fill."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from app.feature import Panel

PANELS = "panels"
"""Below it are the folders of panels' scripts."""
SECTION = """
  <section id="{id}" class="panel" data-tab="map" data-script="{script}"
    aria-labelledby="{id}-title">
    <header><h2 id="{id}-title">{title}</h2></header>
    <div class="parameters added"></div>
  </section>"""


def sections_of(panels: Mapping[str, tuple[Panel, ...]]) -> str:
    """Return the sections of all panels, by the names of their features, as HTML."""
    return "".join(
        SECTION.format(
            id=escape(f"{feature}-{panel.name}"),
            title=escape(panel.title),
            script=escape(f"{PANELS}/{feature}/{panel.name}/{panel.script.name}"),
        )
        for feature, each in panels.items()
        for panel in each
    )
