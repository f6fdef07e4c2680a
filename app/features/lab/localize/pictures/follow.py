"""Follows a robot through its pictures on a taped field."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from app.engine.build import Streams, connect
from app.engine.localization import Localization
from app.features.lab.localize.localize import GivenStart
from app.features.lab.localize.pictures.field_fit import FieldFit
from app.features.lab.localize.pictures.motion import (
    GuessedStep,
    Motion,
    SteadyMotion,
    disagreement,
    is_stale,
    repeats,
    twist_at,
)
from app.features.lab.localize.pictures.sequence import StampedPicture
from app.features.lab.replay_robot import ReplayRobot
from app.settings.config import Config
from robot.cameras.camera import Picture, PictureError, check_size
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.fields.field import Field
from robot.geometry import Array, Pose2
from robot.interface import Frame, Reading, RobotError
from robot.localization.estimate import Integrity, State
from robot.localization.filter import Setup
from robot.scanning.line_scanner import LineScan, LineScanner

FOLLOWS = 0.5
"""Odometry jumped before a picture if the next one agrees with it so much better, by the motion of
its corners, than with the one before. On the lane's sequence, and on it with jumps of 24 degrees,
half and twice of it decide alike."""


@dataclass(frozen=True, eq=False)
class LocatedPicture:
    """What is known after one picture."""

    picture: StampedPicture
    exposed: float
    """When it was exposed: its stamp less the camera's delay [s]."""
    pose: Pose2
    """The robot's pose at that time, in the map."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad] of the last update."""
    state: State
    radius: float
    """The place is within this distance of the pose, in 99.9 % of pictures [m]; or infinite."""
    share: float
    """Of the edges in the last pictures, the share on the field's; nan while it is not known."""


@dataclass
class LocatedPictures:
    """What became of the pictures of a sequence."""

    located: list[LocatedPicture] = field(default_factory=list)
    stale: list[StampedPicture] = field(default_factory=list)
    """Those that show what one before showed, although the robot has moved, as later ones tell."""
    disagreeing: list[StampedPicture] = field(default_factory=list)
    """Those that disagree with odometry, where no later one tells which is right."""
    jumped: list[StampedPicture] = field(default_factory=list)
    """Those before which odometry jumped, as later ones tell."""
    unread: list[StampedPicture] = field(default_factory=list)
    """Files that hold no picture, or half of one, as when the robot was switched off."""
    to_turn: list[StampedPicture] = field(default_factory=list)
    """Pictures that say that they are to be turned, and are not."""
    unmoved: list[StampedPicture] = field(default_factory=list)
    """Those without odometry at their time."""
    unknown: list[StampedPicture] = field(default_factory=list)
    """Those after which the filter knew no place."""


Show = Callable[[LocatedPicture, Picture, LineScan, LineScanner], None]
"""Called with each picture that was used, and what the scanner found in it."""


class PictureFollower(Localization):
    """Scanner and filter of a robot whose steps are guessed where there is no odometry."""

    def __init__(
        self,
        spec: RobotSpec,
        field: Field,
        config: Config,
        start: GivenStart | None,
        *,
        guessing: bool,
    ) -> None:
        """Put the filter at a start in the map; by default at the field's own."""
        self._guessing = guessing
        super().__init__(
            LineScanner(spec.floor_view, config.scanner, field.tape),
            field,
            config.localization,
            Streams.of(config.seed).filter,
        )
        if start is None:
            self.set_pose(field.start)
        else:
            variances = np.square([start.sd_xy, start.sd_xy, start.sd_theta])
            self.set_pose(start.pose, np.diag(variances))

    def _setup(self) -> Setup:
        setup, wanted = super()._setup(), self.parameters.motion
        if not self._guessing:
            return setup
        guessed = GuessedStep(wanted.stationary_sd_xy, wanted.stationary_sd_theta)
        return replace(setup, motion=guessed)


class PictureRun:
    """One run through the pictures of a sequence."""

    def __init__(
        self,
        spec: RobotSpec,
        field: Field,
        config: Config,
        start: GivenStart | None = None,
        odometry: Motion | None = None,
    ) -> None:
        """Prepare a run.

        Args:
            config: settings of scanner and filter, and the seed.
            start: where the robot is at the first picture; by default at the field's start.
            odometry: its motion; by default each step is assumed to be like the one before.
        """
        self.result = LocatedPictures()
        self._spec = spec
        self._guess = SteadyMotion() if odometry is None else None
        self._motion: Motion = odometry or self._guess or SteadyMotion()
        self._follower = PictureFollower(spec, field, config, start, guessing=odometry is None)
        self._fit = FieldFit(field)
        self._config = config
        self._now: tuple[StampedPicture, Picture, Pose2] | None = None
        """The picture of the present step, and the odometry at its exposure."""
        self._doubted: tuple[StampedPicture, Picture, Pose2] | None = None
        """The last picture, if it disagrees with odometry."""

    def follow(self, pictures: Sequence[StampedPicture], show: Show | None = None) -> None:
        """Follow the robot; what is found is in ``result``.

        Args:
            show: called with each picture that was used.

        Raises:
            PictureError: no picture can be read, or the size of one is not that of the lens.
        """
        # A frame's stamp is that of its exposure here: no later reading is needed for the delay.
        prompt = replace(self._spec, picture_delay=0.0)
        robot = ReplayRobot("The sequence", self._readings(pictures), prompt)
        engine = connect(self._config, robot, self._follower)
        with contextlib.suppress(RobotError):  # the end of the pictures
            while True:
                self._follower.update_once()
                engine.step()
                self._keep(show)
        if self._doubted is not None:
            self._give_up(self._doubted)

    def _readings(self, pictures: Sequence[StampedPicture]) -> Iterator[Reading]:
        drive = DifferentialDrive(self._spec)
        still = np.zeros(len(self._spec.joints))
        for picture in pictures:
            try:
                read = picture.read()
            except PictureError:
                self.result.unread.append(picture)
                if len(self.result.unread) == len(pictures):
                    raise
                continue
            check_size(read.pixels.shape, self._spec.lens, str(picture.path))
            if read.asks_to_be_turned:
                self.result.to_turn.append(picture)
            image = read.pixels
            exposed = picture.stamp - self._spec.picture_delay
            odometry = self._motion.at(exposed)
            if odometry is None:
                self.result.unmoved.append(picture)
                continue
            if self._is_doubtful(picture, image, odometry):
                continue
            self._now = picture, image, odometry
            yield Reading(
                exposed,
                still,
                drive.wheels(twist_at(self._motion, exposed)),
                frame=Frame(exposed, image),
                odom_from_robot=odometry,
            )

    def _is_doubtful(self, picture: StampedPicture, image: Picture, odometry: Pose2) -> bool:
        """Return whether picture and odometry disagree; it tells which of both was wrong before."""
        doubted, self._doubted = self._doubted, None
        if doubted is not None and self._has_jumped(doubted, image, odometry):
            self.result.jumped.append(doubted[0])
            return False
        if not self._disagree(image, odometry):
            if doubted is not None:
                self.result.stale.append(doubted[0])
            return False
        if doubted is not None:
            self._give_up(doubted)
        self._doubted = picture, image, odometry
        return True

    def _has_jumped(
        self, doubted: tuple[StampedPicture, Picture, Pose2], image: Picture, odometry: Pose2
    ) -> bool:
        """Whether a picture follows the one that disagreed, and not the one before."""
        if self._now is None or self._guess is not None or repeats(doubted[1], image):
            return False
        before, since = (
            disagreement(seen, image, pose.inverse() @ odometry, self._spec.floor_view)
            for _, seen, pose in (self._now, doubted)
        )
        return since < FOLLOWS * before

    def _give_up(self, doubted: tuple[StampedPicture, Picture, Pose2]) -> None:
        """Note a picture of which later ones do not tell whether it is right."""
        alike = self._now is not None and repeats(self._now[1], doubted[1])
        (self.result.stale if alike else self.result.disagreeing).append(doubted[0])

    def _disagree(self, image: Picture, odometry: Pose2) -> bool:
        if self._now is None:
            return False
        _, before, pose = self._now
        moved = None if self._guess is not None else pose.inverse() @ odometry
        return is_stale(before, image, moved, self._spec.floor_view)

    def _keep(self, show: Show | None) -> None:
        assert self._now is not None  # a step had a picture
        picture, image, odometry = self._now
        belief, line_scan = self._follower.belief, self._follower.line_scan
        if belief is None or line_scan is None:
            self.result.unknown.append(picture)
            return
        exposed, pose = line_scan.scan.stamp, belief.pose(odometry)
        self._fit.observe(line_scan.scan, pose)
        integrity = self._fit.judged(self._claimed(odometry))
        located = LocatedPicture(
            picture,
            exposed,
            pose,
            belief.estimate.hypotheses[0].covariance,
            integrity.state,
            integrity.radius,
            self._fit.share,
        )
        self.result.located.append(located)
        if self._guess is not None:
            self._guess.learn(exposed, pose)
        if show is not None:
            show(located, image, line_scan, self._follower.scanner)

    def _claimed(self, odometry: Pose2) -> Integrity:
        claimed = self._follower.integrity_at(odometry)
        if self._guess is None or not math.isfinite(claimed.radius):
            return claimed
        # Along straight tape, nothing tells a guessed step from the true one.
        return Integrity(State.APPROXIMATE, alerts=claimed.alerts)
