"""TapeCompanion: takes the watches of tape along with an engine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from app.engine.controls import Controls
from app.features.misplaced_tape.laid_watch import LaidWatch
from app.features.misplaced_tape.place_watch import Outline, PlaceWatch
from app.features.misplaced_tape.watch import TapeWatch
from app.messages.commands import Command
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.interface import Reading, Robot
from robot.localization.monitoring.mounting_check import CameraPosition
from robot.scan import Scan

MOST_EDGES = 600
"""In drawings of more edges no single piece is looked for: it would take too long."""


def tape_watches(config: Config, floor: Field) -> Sequence[PlaceWatch]:
    """Return what watches the tape of an engine's field; nothing if it is of walls."""
    if not floor.tape or floor.grid is not None:
        return []
    # A piece that lies elsewhere does so besides what all tape does.
    pieces = [TapeWatch(floor)] if len(floor.edges) <= MOST_EDGES else []
    return [LaidWatch(floor), *pieces]


class TapeCompanion:
    """Shows the watches what the filter made of each scan, and tells the filter a place."""

    needs_pictures = False

    def __init__(self) -> None:
        self.shown: Outline | None = None
        """Where the drawing has tape that does not lie there."""
        self._map_from_odom = Pose2()
        """Where somebody has put the robot, and that was told."""
        self._newest: tuple[Scan, Pose2] | None = None

    def commands(self, odom_from_robot: Pose2, controls: Controls) -> Iterable[Command]:
        """Give no commands: a replay finds the same place by itself."""
        return ()

    def add(self, reading: Reading, controls: Controls) -> None:
        """Show them what the filter made of the newest scan."""
        localization = controls.localization
        newest, belief = localization.newest, localization.belief
        if newest is self._newest or newest is None or belief is None:
            return
        self._newest, odometry = newest, newest[1]
        claim, estimate = localization.integrity, belief.estimate
        self.shown = None
        for models in localization.added:
            if not isinstance(models, PlaceWatch) or localization.paused:
                continue
            if controls.map_from_odom != self._map_from_odom:
                models.forget()
            self.shown = models.outline or self.shown
            best = max(estimate.hypotheses, key=lambda each: each.weight, default=None)
            if isinstance(models, LaidWatch):
                models.mounting = CameraPosition.of(localization.scanner.view)
            if best is not None:
                pose = best.pose @ belief.moved(odometry)
                models.look(claim, pose, best.covariance, odometry)
            present = controls.odometry.at(reading.stamp).odom_from_robot
            place = models.place(claim.state, belief.pose(present), present)
            if place is not None:
                localization.note(present)
                localization.set_pose(*place)
        self._map_from_odom = controls.map_from_odom

    def close(self) -> None:
        """Do nothing: there is no thread."""


def tape_companion(config: Config, robot: Robot, field: Field) -> Iterable[TapeCompanion]:
    """Return what goes along with an engine."""
    return (TapeCompanion(),)
