"""Boards that lie on the floor, seen by a robot that is not quite as described."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from board_pictures import paper
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.description.spec import RobotSpec
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Pose2, Twist2
from sim.floor_camera import CameraSettings, FloorCamera
from sim.imperfections import Imperfections, draw

SPEC = RobotSpec.load()
PLACED = Pose2(0.19, -0.125, 0.0)
"""Where the board lies: its frame in the robot's."""
FINE = 0.00025
"""Side of the floor's pixels [m]."""
FLOOR = (-0.2, -0.5, 0.9, 0.5)
"""Extent of the floor [m]."""


def floor(
    board: Board, placed: Pose2 = PLACED, tape: float | None = None, scale: float = 1.0
) -> FloorPicture:
    """The floor from above, with a board printed at a scale, and a strip of tape of that width."""
    xmin, ymin, xmax, ymax = FLOOR
    size = round((xmax - xmin) / FINE), round((ymax - ymin) / FINE)
    image = np.full(size[::-1], 225, np.uint8)
    if tape is not None:
        start = round((xmax - 0.36 - xmin) / FINE)
        image[:, start : start + round(tape / FINE)] = 30
    drawn = paper(board)
    # From the paper's pixels (x right, y down) to the board's frame, then to the floor's pixels.
    step = scale * board.square / 40
    margin = len(drawn) - 40, drawn.shape[1] - 40
    paper_to_board = np.array([[0, -step, margin[0] * step - step / 2],
                               [-step, 0, margin[1] * step - step / 2], [0, 0, 1]])  # fmt: skip
    c, s = np.cos(placed.theta), np.sin(placed.theta)
    board_to_robot = np.array([[c, -s, placed.x], [s, c, placed.y], [0, 0, 1]])
    robot_to_floor = np.array([[1, 0, -xmin], [0, -1, ymax], [0, 0, FINE]]) / FINE
    robot_to_floor[:2, 2] -= 0.5
    transform = (robot_to_floor @ board_to_robot @ paper_to_board)[:2]
    flags = cv2.INTER_LINEAR
    cv2.warpAffine(drawn, transform, size, image, flags, cv2.BORDER_TRANSPARENT)
    return FloorPicture(image, FINE, FLOOR)


def built(seed: int) -> RobotSpec:
    """A robot whose camera is 1.5 degrees and 5 mm askew (standard deviations)."""
    askew = replace(Imperfections.none(), camera_angle_sd=1.5, camera_position_sd=0.005)
    return draw(SPEC, askew, np.random.default_rng(seed))


def seen_by(
    spec: RobotSpec, below: FloorPicture, seed: int, noise: float = 3.0
) -> NDArray[np.uint8]:
    """The picture of a standing robot at the floor's origin."""
    camera = FloorCamera(spec.floor_view, below, CameraSettings(), np.random.default_rng(seed))
    return camera.picture(Pose2(), Twist2())
