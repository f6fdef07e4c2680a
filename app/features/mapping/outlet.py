"""What draws a map of the floor as long as a program runs, and shows it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

from fastapi import APIRouter

from app.engine.snapshot import Snapshot
from app.features.mapping.commands import DRAWER, SAVER
from app.features.mapping.map_drawer import MapDrawer
from app.features.mapping.map_layer import MapLayer
from app.features.mapping.map_saver import MapSaver
from app.features.mapping.routes import mapping_message, mapping_router, sketch_of
from app.page.outlets import Outlet, Outlets
from app.page.view.scene import NewViewLayer


class MappingOutlet(Outlet):
    """The map of one program."""

    def __init__(self, outlets: Outlets) -> None:
        """Prepare to draw."""
        self.drawer = MapDrawer(outlets.program)
        self._saver = MapSaver(outlets.program, self.drawer, outlets.changes)

    @property
    def parts(self) -> Mapping[str, object]:
        """What draws maps, and what saves them."""
        return {DRAWER.name: self.drawer, SAVER.name: self._saver}

    def routers(self) -> Iterable[APIRouter]:
        """Return the routes that show the map."""
        return (mapping_router(self.drawer),)

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return how far the map is."""
        return {"mapping": mapping_message(self.drawer.drawing, snapshot)}

    def view_layers(self) -> Iterable[NewViewLayer]:
        """Return the layer that shows the map."""
        return (partial(MapLayer, sketch=partial(sketch_of, self.drawer)),)

    def require_endable(self) -> None:
        """Refuse to lose a map that is not saved."""
        self.drawer.require_none_lost()

    def close(self) -> None:
        """End the drawing."""
        self.drawer.close()
