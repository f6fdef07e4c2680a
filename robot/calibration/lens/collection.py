"""Collects pictures of a board: says which count, and what is still missing."""

from __future__ import annotations

from dataclasses import dataclass, field

from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.coverage import Coverage
from robot.calibration.lens.lens_calibration import LensCalibration, calibrate_lens, of_no_use
from robot.calibration.lens.sighting import Grey, Sighting, SightingError


@dataclass
class PictureCollection:
    """Guides a person who takes pictures, in a window or on a page."""

    board: Board
    seen: dict[str, Sighting] = field(default_factory=dict)
    """The pictures that count, by name, in the order of their arrival."""

    def add(self, name: str, picture: Grey) -> str:
        """Keep a grey picture (h, w) if it is useful; else return the reason.

        A picture is useless if its size differs from the first, or if it is blurred or repeated.
        """
        try:
            sighting = find_board(picture, self.board)
        except SightingError as error:
            return str(error)
        return self.take(name, sighting)

    def take(self, name: str, sighting: Sighting) -> str:
        """Keep what a picture shows if it is useful; else return the reason."""
        # Compared with sharper pictures that came later, an earlier one may be blurred.
        useless = of_no_use(self.seen | {name: sighting}, self.board)
        self.seen[name] = sighting
        for bad in useless:
            del self.seen[bad]
        return useless.get(name, "")

    @property
    def coverage(self) -> Coverage:
        """What the pictures cover so far, and what they lack."""
        return Coverage.of(list(self.seen.values()), self.board)

    def calibrate(self) -> LensCalibration:
        """Calibrate the lens with the pictures so far.

        Raises:
            LensError: they are too few, or no lens fits them.
        """
        return calibrate_lens(self.seen, self.board, {})
