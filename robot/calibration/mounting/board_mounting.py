"""The camera's mounting by a printed board that lies on the floor at a known place."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from robot.calibration.lens.adjustment import board_pose, fit_pose
from robot.calibration.lens.board import Board
from robot.calibration.lens.sighting import Grey, Sighting
from robot.calibration.mounting.mounting import (
    Mounting,
    MountingError,
    derivatives,
    step_between,
    vague,
)
from robot.camera import FloorView, Lens
from robot.estimation.fit_quality import FitQuality, correlation_of, robust_sd
from robot.geometry import Array, Pose2
from robot.interface import Frame
from robot.scanning.line_scanner import LineScanner, LineScannerSettings
from robot.scanning.tape import BLACK_TAPE
from robot.scanning.tape_edges import Verdict

PLACED_SD = np.array([0.001, 0.001, math.radians(0.3)])
"""How well a board is laid by hand where it is said to lie [m, m, rad]."""
LEAST_SD_PX = 0.05
"""Corners scatter by at least this [px]: some errors of a picture are common to all corners."""
FAR_OFF_PX = 2.0
"""Corners that lie farther off [px] are of a bent board, or seen through another lens."""
TURNED = math.radians(60)
"""A camera that is turned by more against its description is none: the board lies otherwise."""
LEAST_RAYS = 12
"""Fewest rays that tell the tape's width."""
SCALE = 0.02
"""The tape must be as wide as told to this share."""


def mounting_by_board(
    lens: Lens,
    sighting: Sighting,
    board: Board,
    placed: Pose2,
    described: Array,
) -> Mounting:
    """Return the mounting by a board on the floor.

    Args:
        lens: the camera's.
        sighting: the board in the picture.
        board: the board.
        placed: the board's frame in the robot's frame.
        described: (4, 4) pose of the camera in the robot's description. It tells which side of the
            board is up, where the squares do not.

    Raises:
        CameraError: the lens shows too few of the corners.
        MountingError: the board does not lie as told, or is not flat, or the lens is another.
    """
    views = [
        fit_pose(lens, view, board, board_pose(lens, view, board))
        for view in _turned(sighting, board)
    ]
    turns = [_angle(_robot_from_camera(view.pose, placed), described) for view in views]
    index = int(np.argmin(turns))
    fit, turn = views[index], turns[index]
    rms = float(np.sqrt((fit.errors**2).sum(axis=1).mean()))
    if rms > FAR_OFF_PX:
        raise MountingError(
            f"the corners lie {rms:.1f} px off a flat board seen through this lens: do the "
            "squares have the given size, is the board flat, and is the lens file this camera's?"
        )
    if turn > TURNED:
        raise MountingError(
            f"the camera would be turned by {math.degrees(turn):.0f} degrees against its "
            "description: the board lies otherwise; its x axis points along --at's THETA"
        )
    start = _robot_from_camera(fit.pose, placed)

    def change(pose: Array, placement: Array) -> Array:
        return step_between(start, _robot_from_camera(pose, Pose2.from_array(placement)))

    laid = placed.to_array()
    count = fit.errors.size
    variance = max(float((fit.errors**2).sum()) / max(1, count - 6), LEAST_SD_PX**2)
    by_pose = derivatives(lambda pose: change(pose, laid), fit.pose)
    by_place = derivatives(lambda placement: change(fit.pose, placement), laid)
    covariance = by_pose @ (variance * np.linalg.inv(fit.information)) @ by_pose.T
    covariance += by_place @ np.diag(PLACED_SD**2) @ by_place.T
    quality = FitQuality(
        robust_sd(fit.errors) / math.sqrt(variance),
        correlation=correlation_of(fit.errors.ravel("F")),
        unobservable=vague(covariance),
    )
    return Mounting(start, covariance, fit.errors.ravel(), quality)


def check_scale(
    picture: Grey,
    lens: Lens,
    mounting: Mounting,
    sighting: Sighting,
    board: Board,
    settings: LineScannerSettings,
) -> float | None:
    """Return the tape's width in the picture [m], beside the board; None without tape.

    Raises:
        MountingError: the tape seems wider or narrower than it is: the squares have another size.
    """
    without = _painted_over(picture, sighting)
    view = FloorView(lens, mounting.robot_from_camera)
    true = settings.tape_width or BLACK_TAPE.width
    wide = replace(settings, width_tolerance=0.3 * true)
    scan = LineScanner(view, wide).scan(Frame(0.0, without))
    if (scan.verdicts == Verdict.COUNTED).sum() < LEAST_RAYS:
        return None
    share = scan.tape_width / true
    if abs(share - 1) > SCALE:
        raise MountingError(
            f"the tape seems {1e3 * scan.tape_width:.1f} mm wide where it is "
            f"{1e3 * true:.1f} mm: the squares are not {1e3 * board.square:.2f} mm "
            f"but {1e3 * board.square / share:.2f} mm; measure them, and give --size "
            "(if they are right, the lens file is not this camera's)"
        )
    return scan.tape_width


def _painted_over(picture: Grey, sighting: Sighting) -> Grey:
    """Return the picture with the board's tone where the board is."""
    result = picture.copy()
    hull = cv2.convexHull(sighting.pixels.astype(np.float32)).reshape(-1, 2)
    middle = hull.mean(axis=0)
    # The squares reach one farther than the inner corners, and the paper farther still.
    outline = np.rint(middle + 1.8 * (hull - middle)).astype(np.int32)
    inside = np.zeros(picture.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.rint(hull).astype(np.int32), 1)
    cv2.fillConvexPoly(result, outline, float(np.percentile(picture[inside > 0], 90)))
    return result


def _turned(sighting: Sighting, board: Board) -> Iterator[Sighting]:
    """Yield the sighting with each side of the board up that looks the same."""
    yield sighting
    if board.kind != "chessboard":
        return
    across, up = board.inner
    grid = np.arange(across * up).reshape(up, across)
    quarters = (1, 2, 3) if across == up else (2,)
    for quarter in quarters:
        yield replace(sighting, ids=np.rot90(grid, quarter).ravel()[sighting.ids])


def _robot_from_camera(pose: Array, placed: Pose2) -> Array:
    camera_from_board = np.eye(4)
    camera_from_board[:3, :3] = Rotation.from_rotvec(pose[:3]).as_matrix()
    camera_from_board[:3, 3] = pose[3:]
    robot_from_board = np.eye(4)
    robot_from_board[:3, :3] = Rotation.from_euler("z", placed.theta).as_matrix()
    robot_from_board[:2, 3] = placed.x, placed.y
    result: Array = robot_from_board @ np.linalg.inv(camera_from_board)
    return result


def _angle(pose: Array, other: Array) -> float:
    """Return the angle between two poses (4, 4) [rad]."""
    return float(np.linalg.norm(step_between(other, pose)[:3]))
