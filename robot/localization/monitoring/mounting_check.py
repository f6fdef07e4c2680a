"""Checks the camera's mounting and the map's scale by what no pose explains in scans.

The pose is projected out of the residuals, as satellite receivers do it (RAIM, Brown 1992); what is
left is compared with what a pitch or roll of the camera, or another scale of the map, would leave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot.camera import FloorView
from robot.compiling import compiled
from robot.covariance import inverse
from robot.geometry import Array
from robot.localization.monitoring.steady_errors import MEMORY, SteadyErrors


@dataclass(frozen=True, slots=True)
class CameraPosition:
    """Position of the camera on the robot; how a tilt changes ranges depends on it."""

    x: float
    """Ahead of the robot's origin [m]."""
    height: float
    """Above the floor [m]."""

    @classmethod
    def of(cls, view: FloorView) -> CameraPosition:
        """Return the position of a camera above the floor."""
        x, _, height = view.robot_from_camera[:3, 3].tolist()
        return cls(x, height)

    def shifts(self, points: Array) -> Array:
        """Return how pitch and roll move floor points (n, 2) in the robot frame (n, 2, 2) [m/rad].

        The first index is the point, the second x or y, the third pitch or roll.
        """
        x, y = points[:, 0] - self.x, points[:, 1]
        h = self.height
        across = x * y / h
        return np.stack(
            [
                np.column_stack([(x * x + h * h) / h, across]),
                np.column_stack([across, (y * y + h * h) / h]),
            ],
            axis=1,
        )


LASER = CameraPosition(0.0, math.inf)
"""A laser measures ranges directly, and not by points that it sees on the floor."""


RAYS_WORTH = 0.1
"""Weight of one ray: the errors of neighbouring rays, and of successive scans, are correlated.
Half: misleading in 1.8 % of pictures instead of 0.7; twice: in 0.3, and 40.3 % certain instead of
40.7 (``python -m benchmarks.constants --few``)."""
EXACT, INEXACT, ADAPTED = 0.15, 4.0, 0.1
"""Least and largest distance of rays from their edges, in usual spreads, and the share of it that
is learnt from one scan. Without this, a few rays that meet a wrong edge would count for more than
all exact ones. Half and twice of INEXACT: no claim changes (``--few``)."""
HELD = np.diag(1 / np.square([0.03, 0.03, 0.1]))
"""Information besides a scan, which holds a pose where it was [1/m², 1/m², 1/rad²]."""
DIRECTION_SD = 0.05
"""Standard deviation of an edge's direction [rad]. Edges that are parallel to within this tell
nothing along them: else a unit of tilt or scale would seem to shift the pose by hundreds of metres
where edges cross at a milliradian."""
STANDS_OUT, EXPLAINS = 2.0, 0.3
"""A tilt is taken off the scans if it exceeds this many standard deviations, and explains more than
this share of the residuals. Half of STANDS_OUT: no claim changes; twice: nothing changes beyond
chance (``--few``)."""
SCALE_SD, SCALE_DOUBTED = 0.008, 0.015
"""Standard deviation of the scale of a map that was tried, and of one that was not, or is doubted.
Half of SCALE_SD: misleading in 0.8 % instead of 0.7; twice: in 0.2, and as many certain
(``--few``)."""
TRIED_TO = 0.012
"""Steps try a map's scale to this, over a metre between what it was seen from [m]. Half: on floors
that are 3 % smaller 0.13 % are certain and wrong, not none; a quarter: the same; as many are
certain (``brickpose evaluate integrity --map square tee stub town --start known --condition
enlarged shrunk --first-seed 24600 --seeds 2 --laps 1``)."""
USUAL = SteadyErrors()
BLEND = 0.2
"""Share of a change of the tilt that is taken off the next scan."""


@dataclass(frozen=True, slots=True, eq=False)
class ApparentErrors:
    """Apparent errors of the camera's mounting and of the map's scale."""

    pitch: float
    """[rad], positive where ranges are too long."""
    roll: float
    """[rad]"""
    scale: float
    """Error of the map's scale, as a share: positive where the floor is larger than drawn."""
    covariance: Array = field(repr=False)
    """(3, 3) of these."""
    explained: float
    """Share of the residuals that these errors explain, of those that no pose explains."""
    unexplained: float
    """Mean square of the remaining residuals, in spreads of a ray."""

    @property
    def tilt(self) -> float:
        """Pitch and roll together [rad]."""
        return math.hypot(self.pitch, self.roll)


class MountingCheck:
    """Estimates the mounting error from the sums of all scans."""

    def __init__(self, errors: SteadyErrors = USUAL) -> None:
        """Begin with how large the errors may be."""
        self._prior = np.diag(errors.mounting**-2)
        self._tried = np.full(2, np.inf), np.full(2, -np.inf)
        """Least and largest shift of the place per unit of the map's scale, by views that fit."""
        self.forget()

    def forget(self) -> None:
        """Forget the camera's error; the map stays the same, whatever moved the robot."""
        self._sums = np.zeros((4, 4))
        self._rays = 0.0
        self._pose_by_errors = np.zeros((3, 3))
        """(3, 3) pose error [m, m, rad] per unit of pitch, roll and scale, at the last scan."""
        self.exactness = 0.25
        """How far rays lie from their edges, in usual spreads."""
        self.applied = np.zeros(2)
        """Pitch and roll [rad] that are taken off the scans."""
        self.error = self._likeliest()
        """The likeliest errors, including what is already taken off."""

    def observe(self, sums: Array, rays: int, elapsed: float) -> None:
        """Add a scan.

        Args:
            sums: sums (7, 7) of the scan by ``residual_sums``.
            rays: number of rays that lie on an edge.
            elapsed: time since the last scan [s].
        """
        keep = math.exp(-elapsed / MEMORY)
        left = self.look(sums)
        self._sums = keep * self._sums + left
        self._rays = keep * self._rays + rays
        self.error = self._likeliest()
        exactness = self.exactness * self.error.unexplained ** (0.5 * ADAPTED)
        self.exactness = min(max(exactness, EXACT), INEXACT)

    def look(self, sums: Array) -> Array:
        """Update only how tilt and scale shift the pose; return what no pose explains (4, 4)."""
        left, self._pose_by_errors = _project_out_pose(sums, self._pose_by_errors)
        return left

    def follow(self) -> None:
        """Take a significant tilt off the next scans."""
        error = self.error
        tilt = np.array([error.pitch, error.roll])
        sure = tilt @ np.linalg.solve(error.covariance[:2, :2], tilt) > STANDS_OUT**2
        wanted = tilt if sure and error.explained > EXPLAINS else np.zeros(2)
        self.applied = self.applied + BLEND * (wanted - self.applied)

    def _likeliest(self) -> ApparentErrors:
        values, covariance, explained, rest = _solve(self._sums, self._rays, self._prior)
        pitch, roll, scale = values.tolist()
        return ApparentErrors(pitch, roll, scale, covariance, explained, rest)

    def try_scale(self) -> None:
        """Let the last scan's view try the map's scale: the step to it fitted odometry, or slip.

        Tape that is seen on the left says where a robot is on a floor that is too large otherwise
        than tape on the right.
        """
        view, (least, largest) = self._pose_by_errors[:2, 2], self._tried
        self._tried = np.minimum(least, view), np.maximum(largest, view)

    @property
    def scale_sd(self) -> float:
        """Standard deviation of the map's scale [-], as far as views have tried it."""
        apart = float(np.hypot(*np.maximum(self._tried[1] - self._tried[0], 0.0)))
        return max(SCALE_SD, 1 / math.hypot(1 / SCALE_DOUBTED, apart / TRIED_TO))

    def view_variance(self, sums: Array) -> float:
        """Return the variance [m²] of how far steady errors move the place by a scan's new view."""
        changed = (_project_out_pose(sums, self._pose_by_errors)[1] - self._pose_by_errors)[:2]
        spreads = self.error.covariance + np.diag([0.0, 0.0, SCALE_SD**2])
        return float(np.trace(changed @ spreads @ changed.T))

    def pose_error(self, *, map_doubted: bool = False) -> tuple[Array, Array]:
        """Return the error of the last pose by what is not taken off, along the map's axes.

        Args:
            map_doubted: whether an alert says that the map is wrong.

        Returns:
            Mean (3,) and covariance (3, 3) [m, m, rad].
        """
        pitch, roll = self.applied.tolist()
        error, scale_sd = self.error, SCALE_DOUBTED if map_doubted else self.scale_sd
        left = np.array([error.pitch - pitch, error.roll - roll, error.scale])
        spreads = error.covariance + np.diag([0.0, 0.0, scale_sd**2])
        caused = self._pose_by_errors
        return caused @ left, caused @ spreads @ caused.T


@compiled()
def _solve(sums: Array, rays: float, prior: Array) -> tuple[Array, Array, float, float]:
    """Return pitch, roll and scale (3,) that explain most of the residuals in sums (4, 4).

    ``prior`` is the information (3, 3) on them before any scan.

    Also returns their covariance (3, 3), the share that they explain, and the mean square of the
    rest.
    """
    columns = np.ascontiguousarray(sums[:3, :3])
    pull = np.ascontiguousarray(sums[:3, 3])
    covariance = inverse(RAYS_WORTH * columns + prior)
    values = covariance @ (RAYS_WORTH * pull)
    whole = max(sums[3, 3], 1e-12)
    explained = 2 * values @ pull - values @ (columns @ values)
    return values, covariance, explained / whole, (whole - explained) / max(rays, 1.0)


@compiled()
def _project_out_pose(sums: Array, caused: Array) -> tuple[Array, Array]:
    """Project the pose out of a scan's sums, and update how tilt and scale shift the pose.

    Args:
        sums: sums (7, 7) by ``residual_sums``.
        caused: pose error per unit of pitch, roll and scale (3, 3) before the scan.

    Returns:
        Sums (4, 4) that no pose explains, and the pose error (3, 3) after the scan.
    """
    by_pose = np.ascontiguousarray(sums[:3, :3]) * RAYS_WORTH
    across = np.ascontiguousarray(sums[:3, 3:])
    gain = inverse(by_pose + np.eye(3)) @ (across * RAYS_WORTH)
    left = sums[3:, 3:] - np.ascontiguousarray(across.T) @ gain
    # Where a scan gives no information, the pose error stays.
    held = HELD + DIRECTION_SD**2 * _strongest(by_pose) * np.diag(np.array([1.0, 1.0, 0.0]))
    by_errors = np.ascontiguousarray(across[:, :3]) * RAYS_WORTH
    return left, inverse(by_pose + held) @ (held @ caused - by_errors)


@compiled()
def _strongest(information: Array) -> float:
    """Return the largest information on the position along any direction [1/m²]."""
    xx, xy, yy = information[0, 0], information[0, 1], information[1, 1]
    return float(0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy))
