"""Rendered pictures of printed boards."""

from __future__ import annotations

import math
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robot.calibration.lens.board import Board
from robot.camera import Lens
from robot.geometry import Array

CHESSBOARD = Board("chessboard", 10, 7, 0.025)
CHARUCO = Board("charuco", 7, 5, 0.035)
PX_A_SQUARE = 40
OVER = 2
"""Samples of a pixel, along each side."""


def lens_of(model: str = "plumb_bob", *, scale: float = 1.0) -> Lens:
    """A lens of the model, for pictures of 640 x 480 px."""
    focal, coefficients = {
        "plumb_bob": (530.0, [0.16, -0.28, 0.001, -0.002, 0.0]),
        "rational_polynomial": (340.0, [5.2, 3.1, 0.0004, -0.0003, 0.2, 5.5, 4.9, 0.9]),
        "equidistant": (260.0, [-0.02, 0.004, -0.003, 0.0006]),
    }[model]
    matrix = np.array([[scale * focal, 0, 327.0], [0, scale * 1.005 * focal, 233.0], [0, 0, 1]])
    return Lens(640, 480, matrix, np.array(coefficients), model=model)


@cache
def paper(board: Board) -> NDArray[np.uint8]:
    """The board from above, upright, with a white margin of a square."""
    size = (PX_A_SQUARE * board.columns, PX_A_SQUARE * board.rows)
    if board.kind == "charuco":
        drawn = np.asarray(board.markers.generateImage(size))
    else:
        row, column = np.indices((board.rows, board.columns))
        dark = np.where((row + column) % 2 == 0, 20, 235).astype(np.uint8)
        drawn = np.kron(dark, np.ones((PX_A_SQUARE, PX_A_SQUARE), np.uint8))
    return np.pad(drawn, PX_A_SQUARE, constant_values=235)


@cache
def _rays(key: tuple[str, float]) -> Array:
    lens = lens_of(key[0], scale=key[1])
    parts = (np.arange(OVER) + 0.5) / OVER - 0.5
    columns = (np.arange(lens.width)[:, None] + parts).ravel()
    rows = (np.arange(lens.height)[:, None] + parts).ravel()
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    return lens.unproject(pixels)


def picture(
    board: Board,
    camera_from_board: Array,
    rng: np.random.Generator,
    model: str = "plumb_bob",
    *,
    scale: float = 1.0,
    noise: float = 3.0,
) -> NDArray[np.uint8]:
    """What a camera sees of a board (4, 4) before grey."""
    lens, rays = lens_of(model, scale=scale), _rays((model, scale))
    normal, origin = camera_from_board[:3, 2], camera_from_board[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        points = rays * ((normal @ origin) / (rays @ normal))[:, None]
    x, y, _ = ((points - origin) @ camera_from_board[:3, :3]).T
    drawn, scaling = paper(board), PX_A_SQUARE / board.square
    # x points up the page and y to its left, from its lower right corner.
    column = drawn.shape[1] - PX_A_SQUARE - y * scaling - 0.5
    row = drawn.shape[0] - PX_A_SQUARE - x * scaling - 0.5
    shape = (OVER * lens.height, OVER * lens.width)
    places = [
        np.nan_to_num(part, nan=-9.0).clip(-9, 9999).reshape(shape).astype(np.float32)
        for part in (column, row)
    ]
    sampled = cv2.remap(drawn, *places, cv2.INTER_LINEAR, borderValue=120)
    grey = cv2.resize(sampled, (lens.width, lens.height), interpolation=cv2.INTER_AREA)
    grey = cv2.GaussianBlur(grey, (0, 0), 0.7)
    return np.clip(np.rint(grey + rng.normal(0, noise, grey.shape)), 0, 255).astype(np.uint8)


def pose(
    board: Board, lens: Lens, aim: tuple[float, float], away: float, tilts: tuple[float, ...]
) -> Array:
    """A board whose middle is seen at a pixel, so far away [m], facing the camera but for tilts."""
    middle = np.array([board.rows, board.columns, 0.0]) * board.square / 2
    # Upright: up the page (x) is up in the picture (-y), left (y) is left (-x).
    facing = np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1.0]])
    result = np.eye(4)
    result[:3, :3] = Rotation.from_euler("xyz", tilts).as_matrix() @ facing
    ray = lens.unproject(np.array([aim]))[0]
    result[:3, 3] = away * ray / np.linalg.norm(ray) - result[:3, :3] @ middle
    return result


def poses(board: Board, lens: Lens, count: int, rng: np.random.Generator) -> list[Array]:
    """Boards all over the picture, tilted all ways, wholly in sight."""
    result: list[Array] = []
    length = board.square * math.hypot(board.columns, board.rows)
    corner = np.array([[x, y, 0] for x in (-0.5, board.rows + 0.5)
                       for y in (-0.5, board.columns + 0.5)]) * board.square  # fmt: skip
    while len(result) < count:
        around = 2 * math.pi * len(result) / count
        lean = rng.uniform(0.2, 0.75)
        tilts = (lean * math.sin(around), lean * math.cos(around), rng.uniform(-0.4, 0.4))
        aim = rng.uniform((120, 100), (lens.width - 120, lens.height - 100))
        away = length * lens.matrix[0, 0] / lens.width * rng.uniform(1.2, 2.2)
        trial = pose(board, lens, (aim[0], aim[1]), away, tilts)
        pixels = lens.project(corner @ trial[:3, :3].T + trial[:3, 3])
        if ((pixels > 2) & (pixels < (lens.width - 3, lens.height - 3))).all():
            result.append(trial)
    return result
