"""Plans: the way between two poses, for who asks and does not drive there."""

from __future__ import annotations

import math
import threading
from dataclasses import asdict

from app.engine.program import Program
from app.features.ros.encoding.navigation import path_message
from app.features.ros.incoming import Answer, goal_of
from app.features.ros.message_types import Message, MessageError
from app.features.ros.source import TopicSource
from robot.errors import CommandError
from robot.geometry import Array, Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import Walls

NAME = "compute_path_to_pose"


class Plans:
    """Answers ``compute_path_to_pose``; several threads may ask."""

    def __init__(self, program: Program, source: TopicSource) -> None:
        self._program = program
        self._source = source
        self._lock = threading.Lock()
        self._space: tuple[Walls, FreeSpace] | None = None

    def answer(self, request: Message) -> Answer:
        """Return the way to a goal; a start without a frame is where the robot is.

        Raises:
            MessageError: a pose is not valid.
            CommandError: there is no way, or nobody knows where the robot is; says why.
        """
        latest = self._program.engine.latest.get()
        if latest is None or latest.pose is None:
            raise CommandError("nobody knows yet where the robot is")
        start = latest.pose
        if request.start.header.frame_id:
            start = self._pose(request.start, "start")
        goal = self._pose(request.goal, "goal")
        walls = latest.added.get("walls")
        with self._lock:
            space = self._free(walls if isinstance(walls, Walls) else Walls())
        try:
            legs = find_way(space, start, goal)
        except NoWayError as error:
            raise CommandError(str(error)) from error
        return {"plan": asdict(path_message(self._source, latest.stamp, _poses(legs, start)))}

    def _pose(self, message: Message, name: str) -> Pose2:
        goal = goal_of(self._source, f"{NAME}: {name}", message)
        pose = Pose2(goal.x, goal.y, goal.theta or 0.0)
        if not self._program.field.contains(pose):
            xmin, ymin, xmax, ymax = self._program.field.extent
            raise MessageError(
                f"{NAME}: the {name} ({pose.x:.3f}, {pose.y:.3f}) m is beyond the field; valid is "
                f"x {xmin:.3f} to {xmax:.3f}, y {ymin:.3f} to {ymax:.3f} m"
            )
        return pose

    def _free(self, walls: Walls) -> FreeSpace:
        if self._space is None or self._space[0] != walls:
            settings = self._program.config.group("navigation", NavigationSettings())
            outline = self._program.engine.spec.outline
            self._space = walls, FreeSpace.of(self._program.field, outline, settings, walls)
        return self._space[1]


def _poses(legs: tuple[WayLeg, ...], start: Pose2) -> list[Pose2]:
    points: list[Array] = [pose for leg in legs for pose in leg.poses]
    poses = [Pose2.from_array(each) for each in points] or [start]
    return [Pose2(each.x, each.y, math.remainder(each.theta, math.tau)) for each in poses]
