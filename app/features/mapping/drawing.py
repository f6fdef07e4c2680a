"""How far a map is that is drawn by driving."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from app.engine.control import ControlLoop
from app.engine.snapshot import DrawnMap
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2
from robot.mapping.sketch import Sketch
from robot.mapping.tape_map import TapeMap


@dataclass(frozen=True)
class MapDrawing:
    """The map that is drawn now, or the last one."""

    state: Literal["draw", "finish", "done", "failed"] = "draw"
    began: float | None = None
    """Stamp of the drive's first tick [s]; None before it."""
    seconds: float = 0.0
    """How long the drive is [s]."""
    paused: bool = False
    """Whether no pictures are taken into the map now; the wheels' turns are."""
    version: int = 0
    """How often it was drawn."""
    sketch: Sketch | None = field(default=None, repr=False)
    """None before anything was drawn."""
    cells: OccupancyGrid | None = field(default=None, repr=False)
    """The same in cells; those that nobody saw are unknown."""
    result: TapeMap | None = field(default=None, repr=False)
    """The whole map, when it is done."""
    earlier: tuple[TapeMap, ...] = field(default=(), repr=False)
    """The whole map before each change by hand, the first one first."""
    map_from_odom: Pose2 | None = None
    """Where odometry began in the map."""
    words: str | None = None
    """What is wrong or missing, or why it failed."""
    saved: bool = False
    """Whether the whole map is in a file, as it is now."""

    @property
    def would_be_lost(self) -> bool:
        """Whether another drawing, or another program, would lose it."""
        return self.state in ("draw", "finish") or (self.state == "done" and not self.saved)


class ShownDrawing:
    """The drawing that others see; for any thread."""

    def __init__(self, engine: ControlLoop) -> None:
        """Begin without one; its cells go into the snapshots of an engine."""
        self.now: MapDrawing | None = None
        """The map that is drawn now, or the last one; None without one."""
        self._engine = engine
        self._lock = threading.Lock()

    def begin(self, drawing: MapDrawing | None) -> None:
        """Show another drawing, of which nothing is drawn yet; or none."""
        with self._lock:
            self.now = drawing
            self._engine.drawn.put(None)

    def change(self, grid: OccupancyGrid | None = None, **changes: Any) -> None:
        """Change the drawing, unless it was discarded meanwhile; the grid is the map in cells."""
        with self._lock:
            if self.now is None:
                return
            self.now = replace(self.now, **changes)
            newest = self._engine.latest.get()
            if grid is not None and newest is not None and self.now.map_from_odom is not None:
                drawn = DrawnMap(newest.stamp, grid, self.now.map_from_odom)
                self._engine.drawn.put(drawn)
