"""Draws the costs of ways, and a way around a zone: ``navigation_picture.py FILE.png``."""

from __future__ import annotations

import sys

import cv2
import numpy as np

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import INSCRIBED, LETHAL, FreeSpace
from robot.navigation.planning import plan
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import Walls

ZONE = ((-0.05, -0.45), (0.05, -0.45), (0.05, 0.12), (-0.05, 0.12))
START, GOAL = Pose2(-0.3, -0.2, 0.0), Pose2(0.3, -0.2, 0.0)
SIDE = 480
"""Of the picture [pixels]."""
WALL, NEAR, COST = (60, 15, 90), (150, 110, 175), (40, 120, 235)
WAY, ROBOT = (20, 90, 200), (199, 95, 11)
"""Blue, green, red."""


def main(path: str) -> int:
    field, outline = load_field("square", MAPS), RobotSpec.load().outline
    space = FreeSpace.of(field, outline, NavigationSettings(), Walls(zones=(ZONE,)))
    layer = space.layer().astype(np.float64)
    share = np.clip(layer / INSCRIBED, 0, 1)[..., None] ** 0.6
    cells = (1 - 0.75 * share) * 235 + 0.75 * share * np.array(COST)
    cells[layer == INSCRIBED] = NEAR
    cells[layer >= LETHAL] = WALL
    size = (SIDE, SIDE)
    picture = cv2.resize(cells[::-1].astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)

    def pixels(points: np.ndarray) -> np.ndarray:
        scale = SIDE / (layer.shape[1] * space.settings.resolution)
        places = (points - np.array(space.origin)) * [scale, scale]
        return np.rint(np.column_stack([places[:, 0], SIDE - places[:, 1]])).astype(np.int32)

    legs = plan(space, START, GOAL)
    way = pixels(np.concatenate([leg.poses[:, :2] for leg in legs]))
    cv2.polylines(picture, [way], False, (255, 255, 255), 6, cv2.LINE_AA)
    cv2.polylines(picture, [way], False, WAY, 3, cv2.LINE_AA)
    for pose in (START, GOAL):
        cv2.polylines(picture, [pixels(pose.apply(outline))], True, ROBOT, 2, cv2.LINE_AA)
    few = (cv2.IMWRITE_PNG_COMPRESSION, 9)
    return 0 if cv2.imwrite(path, picture, few) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
