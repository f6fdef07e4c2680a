"""A program that is stepped by hand while a map is drawn of its floor."""

from __future__ import annotations

from engine_runs import EIGHT, kinematic, run

from app.engine.snapshot import Snapshot
from app.features.mapping.commands import DRAWER
from app.page.outlets import Outlets

LAP_S = 17.0
LONGEST_S = 300.0
LAG_S = 1.6
"""A map is drawn each half second, eight pictures at a time, of what was driven by then [s]."""


class MappingBench:
    """A program with all that is around it, and its drawer."""

    def __init__(self, **settings) -> None:
        self.program = kinematic(**settings)
        self.outlets = Outlets(self.program)
        self.drawer = self.outlets.part(DRAWER)
        run(self.program, 0.2)

    def wait(self) -> None:
        """Wait for the end of the drawer's thread."""
        self.drawer._follower.wait(LONGEST_S)
        if self.drawer._follower.running:
            raise TimeoutError(f"the drawer did not end within {LONGEST_S:.0f} s")

    def drive(self, seconds: float) -> Snapshot:
        """Drive the eight, and wait until something is drawn."""
        snapshot = run(self.program, seconds, EIGHT)[-1]
        while self.drawer._follower.running and self.drawer.drawing.version == 0:
            self.drawer._follower.wait(0.05)
        return snapshot

    def catch_up(self, snapshot: Snapshot) -> None:
        """Wait until the map has what was seen up to a tick, but for what is not due yet."""
        while self.drawer._follower.running and (drawing := self.drawer.drawing).state == "draw":
            if drawing.sketch is not None and drawing.sketch.stamp > snapshot.stamp - LAG_S:
                return
            self.drawer._follower.wait(0.05)

    def follow(self, snapshot: Snapshot) -> None:
        """Wait until the map is as far behind a tick as while driving; a robot may stand, too."""
        for _ in range(20):
            sketch = self.drawer.drawing.sketch
            if sketch is None or sketch.stamp > snapshot.stamp - LAG_S:
                return
            self.drawer._follower.wait(0.02)

    def finish(self) -> None:
        """Finish the map."""
        self.drawer.finish()
        self.wait()
        assert self.drawer.drawing.state != "failed", self.drawer.drawing.words

    def close(self) -> None:
        self.outlets.close()
