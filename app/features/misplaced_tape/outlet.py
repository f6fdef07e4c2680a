"""What the page's map shows of tape that does not lie where it is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.engine.snapshot import Snapshot
from app.page.outlets import Outlet, Outlets


class MisplacedTapeOutlet(Outlet):
    """Shows where the drawing has it."""

    def __init__(self, outlets: Outlets) -> None:
        """Need nothing of the others."""

    def telemetry(self, snapshot: Snapshot) -> Mapping[str, Any]:
        """Return its outline."""
        return {"misplaced_tape": snapshot.added.get("misplaced_tape")}
