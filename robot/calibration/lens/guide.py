"""Guides whoever holds a board before a running camera: takes pictures by itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.collection import PictureCollection
from robot.calibration.lens.coverage import Coverage, normal, share
from robot.calibration.lens.sighting import Grey, Sighting, SightingError
from robot.geometry import Array

STILL = 0.015
"""A board is still if its corners move by less than this share of the picture's diagonal in a
second: 12 px/s at 640 x 480 px, which shear the picture of a rolling shutter of 20 ms by 0.25 px.
"""
LONGEST_GAP_S = 2.0
"""Pictures farther apart do not tell whether the board is still [s]."""
USUAL_GAP_S = 0.5
"""In a longer gap it may move no farther than in this [s]: a slow computer looks rarely."""
NEW = 0.2
"""A picture is new if it differs from all others by this in place, size and tilt together."""
KNOWN = "there is a picture like this: move it or tilt it"
USUAL_PICTURES = 15
"""With fewer pictures one more is always asked for."""


Verdict = Literal["taken", "moving", "known", "refused"]
"""Of a picture: it counts; the board moves; there is one like it; it is of no use."""


@dataclass(frozen=True)
class BoardView:
    """What one picture of the camera shows."""

    stamp: float
    """Of its exposure [s]."""
    verdict: Verdict
    words: str
    """Why not, for people; empty if it counts."""
    sighting: Sighting | None = field(default=None, repr=False)
    """The board in it, if it was found."""


class LensGuide:
    """Takes a picture whenever the board is sharp, still, and where it was not before."""

    def __init__(self, board: Board) -> None:
        self.collection = PictureCollection(board)
        self.coverage = self.collection.coverage
        """What the pictures cover that were taken so far."""
        self._before: tuple[float, Sighting] | None = None
        self._views: list[Array] = []
        self._count = 0

    @property
    def board(self) -> Board:
        """The board that is looked for."""
        return self.collection.board

    @property
    def next_steps(self) -> list[str]:
        """What to do next with the board, the most useful first; empty if it is enough."""
        more = USUAL_PICTURES - len(self.collection.seen)
        steps = self.coverage.next_steps
        if not steps and more > 0:
            steps = [f"{more} more, each from somewhere new"]
        return steps

    def look(self, stamp: float, picture: Grey) -> BoardView:
        """Look at the newest picture (h, w), exposed at a stamp [s], and take it if it helps."""
        before, self._before = self._before, None
        try:
            sighting = find_board(picture, self.board, hurried=True)
        except SightingError as error:
            return BoardView(stamp, "refused", str(error))
        self._before = stamp, sighting
        if before is None or not _still(before, self._before):
            return BoardView(stamp, "moving", "hold it still", sighting)
        view = _view(sighting, self.board)
        if any(np.abs(view - other).sum() < NEW for other in self._views):
            return BoardView(stamp, "known", KNOWN, sighting)
        self._count += 1
        reason = self.collection.take(f"picture {self._count}", sighting)
        if reason:
            return BoardView(stamp, "refused", reason, sighting)
        # Sharper ones may have put out an earlier one: what that showed is new again.
        seen = list(self.collection.seen.values())
        self._views = [_view(each, self.board) for each in seen]
        self.coverage = Coverage.of(seen, self.board)
        return BoardView(stamp, "taken", "", sighting)


def _still(before: tuple[float, Sighting], newest: tuple[float, Sighting]) -> bool:
    """Return whether the board hardly moved from one picture to the next."""
    (earlier, old), (stamp, new) = before, newest
    common = old.places.keys() & new.places.keys()
    if not (0 < stamp - earlier <= LONGEST_GAP_S and common and old.size == new.size):
        return False
    steps = [old.places[number] - new.places[number] for number in common]
    moved = float(np.linalg.norm(steps, axis=1).mean()) / math.hypot(*new.size)
    return moved < STILL * min(stamp - earlier, USUAL_GAP_S)


def _view(sighting: Sighting, board: Board) -> Array:
    """Return where the board is (5,): place and size by the picture's, and its tilt."""
    place = sighting.pixels.mean(axis=0) / sighting.size
    tilt = normal(sighting, board)[:2]
    return np.array([*place, math.sqrt(share(sighting)), *tilt])
