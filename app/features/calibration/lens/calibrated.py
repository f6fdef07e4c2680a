"""A lens that was calibrated on the page: what is shown of it, and its files."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from app.engine.program import Program
from app.engine.robots import profile_file
from app.features.calibration.lens.messages import (
    LensMessage,
    LensParameterMessage,
    LensRatingMessage,
    LensRefusalMessage,
    Pixels,
)
from app.features.calibration.written_file import written_file
from app.settings.profile_files import profile_before, with_lens, write_profile
from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import missing
from robot.calibration.lens.lens_calibration import LensCalibration, Rating
from robot.calibration.lens.result_file import camera_info_of
from robot.calibration.lens.sighting import Sighting
from robot.description.lens_table import MeasuredLens
from robot.description.profile import Profile
from robot.geometry import Array

INTERVAL = 1.96
"""Half of a 95 % interval, in standard deviations."""


@dataclass(frozen=True)
class CalibratedLens:
    """A lens of a program's robot, and the board that it was measured by."""

    program: Program
    result: LensCalibration
    board: Board

    def message(self) -> LensMessage:
        """Return what a page shows of it."""
        result = self.result
        named = zip(result.lens.parameters.items(), result.sd.tolist(), strict=True)
        seen = list(result.seen.values())
        return LensMessage(
            model=result.chosen.model,
            width=result.lens.width,
            height=result.lens.height,
            pictures=len(seen),
            board=self.board.words,
            ratings=[_rating(rating) for rating in result.ratings],
            parameters=[
                LensParameterMessage(name=name, value=value, interval=INTERVAL * sd)
                for (name, value), sd in named
            ],
            corners=pixels(np.concatenate([sighting.pixels for sighting in seen])),
            errors=pixels(np.concatenate(result.chosen.fit.errors), 3),
            outlines=[outline(sighting) for sighting in seen],
            refused=[
                LensRefusalMessage(picture=picture, reason=reason)
                for picture, reason in result.refused.items()
            ],
            missing=[*result.quality.remarks, *missing(seen, self.board)],
        )

    def camera_info(self) -> str:
        """Return the content of ROS's ``camera_info`` YAML."""
        return camera_info_of(self.result, self.board, self.program.robot.spec.lens.readout)

    def profile(self) -> Profile:
        """Return the robot's profile with this lens; what else was measured of it is kept.

        Raises:
            SpecError: the profile that there is cannot be used, or the lens is for other pictures.
            ContradictionError: the lens contradicts itself.
        """
        spec = self.program.robot.spec.as_drawn
        path = saved_profile(self.program) or profile_file(self.program.config)
        before = profile_before(path, spec) if path else Profile.unmeasured(spec.name, "")
        measured = MeasuredLens(self.result.lens, self.result.sd)
        source, quality = f"lens by {len(self.result.seen)} pictures", self.result.quality
        quality.require_consistent()
        profile = replace(with_lens(before, measured, source), fit=quality.table())
        profile.applied_to(spec)
        return profile

    def save(self) -> None:
        """Put it into the real robot's profile, as ``calibrate lens`` does.

        Raises:
            SpecError, OSError: the profile that there is cannot be used, or not be written.
        """
        path = saved_profile(self.program)
        assert path is not None  # only asked for where there is one
        write_profile(path, self.profile())


def saved_profile(program: Program) -> Path | None:
    """Return the file of a real robot's profile; None for a simulated or recorded robot."""
    return None if program.loop is not None else written_file(program.config)


def outline(sighting: Sighting) -> Pixels:
    """Return the corners around a board."""
    hull = cv2.convexHull(sighting.pixels.astype(np.float32))
    return pixels(hull.reshape(-1, 2).astype(np.float64))


def pixels(places: Array, digits: int = 1) -> Pixels:
    """Return places (n, 2) in the picture as a message has them."""
    return [(u, v) for u, v in places.round(digits).tolist()]


def _rating(rating: Rating) -> LensRatingMessage:
    held_out = rating.rms if math.isfinite(rating.rms) else None
    return LensRatingMessage(model=rating.model, held_out_px=held_out, own_px=rating.fit.rms)
