"""Pictures of tape on the floor by which a camera's mounting is measured."""

from __future__ import annotations

import numpy as np

from app.settings.config import MAPS
from robot.calibration.lens.sighting import Grey
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from sim.floor_camera import CameraSettings, FloorCamera

SQUARE = load_field("square", MAPS)
CORNER = Pose2(0.25, 0.2, 0.6)
"""Where a corner of the square is in sight."""


def tape_picture(spec: RobotSpec, seed: int, stands: Pose2 = CORNER) -> Grey:
    rng = np.random.default_rng(seed)
    camera = FloorCamera(spec.floor_view, SQUARE.floor, CameraSettings(), rng)
    return camera.picture(stands, Twist2())
