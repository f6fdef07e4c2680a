"""The likeliest cause of an error: each leaves a pattern in the residuals of scans and steps.

What half and twice of a constant change is said as ``python -m benchmarks.constants`` found it: of
pictures 0.2 % have a false alarm, and where something is wrong, its cause is named in 61.4 %.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from robot.localization.estimate import Alert, Cause
from robot.localization.monitoring.mounting_check import ApparentErrors
from robot.localization.monitoring.odometry_check import OdometryErrors

RAISED, CLEARED = 0.4, 3.0
"""An alert is raised after its cause was the likeliest for RAISED [s]. It is cleared when its cause
was not the likeliest for CLEARED [s]. Half of RAISED: the cause is named in 63.9 % instead of 61.4;
twice: 55.4, and no false alarm. Half and twice of CLEARED: nothing changes."""
WHEELS_SLIP = 2.8
"""Wheels slip if the unexplained rest of steps in heading is larger than this, in usual spreads.
Half: no false alarm, named in 62.3 %; twice: false in 9.0 %, named in 44.1, as slip then looks like
another cause."""
PATH_TORN = 2.4
"""Poses do not fit together if that rest of steps ahead or aside is larger than this. Half: no
false alarm, named in 61.8 %; twice: no alarm changes."""
LATE, LATE_SURE = 0.012, 2.4
"""Pictures are late if they come later than this [s], and by this many standard deviations. Half of
LATE: no alarm changes; twice: named in 51.8 %. Half of LATE_SURE: 67.5, with as many false ones;
twice: 52.1, and no false alarm."""
TILT, TILT_EXPLAINS = math.radians(0.1), 0.7
"""A camera is askew if its tilt is larger than this [rad], and explains more than this share of the
residuals that no pose explains. Half and twice of the tilt: no alarm changes. With a share of 0.4
the camera is told on two of five floors that were laid by hand, where the map is told now; two
cameras that are askew are told as soon with either; twice names none at all."""
RADII, RADII_TURN = 0.025, 0.38
"""Wheels are of another size if they err by more: a share of a distance, or a turn by distance
[rad/m]. Half and twice: no alarm changes."""
STUCK = 4.0
"""So long after a robot was stuck its steps seem to fit no map [s]. Half and twice: as many robots
hear that they were stuck (``odometry_check.py``)."""
SURE = 3.0
"""Standard deviations above which a wheel's error is significant. Half: false in 2.5 %; twice: no
alarm changes."""
FLAT, FLAT_WIDE = 0.97, 0.010
"""A sensor model rates all poses alike if more than this share of the cloud stays effective, and
the cloud is wider than this [m]. Half of FLAT: false in 1.7 %; a share above one, which disables
it: 0.1 % of the alarms differ. Half and twice of FLAT_WIDE: no alarm changes."""
MIN_FIT_CHANGE = -1.6
"""A sensor model that takes more than this of a ray's log-likelihood does not suit this scanner.
Half: false in 1.3 %; twice: no alarm changes."""
FLAT_RAYS = 20
"""Least number of returns by which a sensor model should have distinguished poses. Half and twice:
no alarm changes."""


@dataclass(frozen=True, slots=True)
class Findings:
    """All quantities by which causes are judged."""

    stamp: float
    elapsed: float
    odometry: OdometryErrors
    mounting: ApparentErrors
    returned: int
    spread: float
    """Share of the cloud that is effective."""
    width: float
    """Width of the hypothesis [m]."""
    stuck_for: float
    """How long ago the robot was last stuck while its wheels turned [s]; inf if never."""
    fit_change: float
    """Change of a ray's log-likelihood by scans that moved the pose to a worse fit; at most 0."""
    model_suspected: bool = True
    """Whether the sensor model may be the cause: it is not ours, or its parameters are others."""


class Causes:
    """Raises and clears alerts, each by its own rule."""

    def __init__(self) -> None:
        self._held: dict[Cause, float] = {}
        """How long each cause has been the likeliest [s]."""
        self._last: dict[Cause, tuple[float, str]] = {}
        """Stamp [s] and text of each cause's last alert."""
        self.alerts: tuple[Alert, ...] = ()

    def forget(self) -> None:
        """Clear all alerts, because another place is followed from now on."""
        self._held, self._last, self.alerts = {}, {}, ()

    def judge(self, findings: Findings) -> None:
        """Update the alerts by the findings of one more scan."""
        cause, text = self._likeliest(findings)
        for each in Cause:
            before = self._held.get(each, 0.0)
            self._held[each] = before + findings.elapsed if each is cause else 0.0
        if cause is not None and self._held[cause] >= RAISED:
            self._last[cause] = findings.stamp, text
        fresh = {c: v for c, v in self._last.items() if findings.stamp - v[0] <= CLEARED}
        self._last = fresh
        newest = sorted(fresh.items(), key=lambda item: -item[1][0])
        self.alerts = tuple(Alert(each, words) for each, (_, words) in newest)

    def _likeliest(self, f: Findings) -> tuple[Cause | None, str]:
        """Return the first cause whose pattern is present: an earlier cause can hide later ones."""
        for cause, pattern in PATTERNS.items():
            text = pattern(f)
            if text:
                return cause, text
        return None, ""


def _model(f: Findings) -> str:
    if not f.model_suspected:
        return ""
    flat = f.spread > FLAT and f.width > FLAT_WIDE and f.returned >= FLAT_RAYS
    if flat:
        return "this sensor model rates all poses alike"
    if f.fit_change < MIN_FIT_CHANGE:
        return "this sensor model moves the robot to where rays do not fit"
    return ""


def _camera(f: Findings) -> str:
    if f.mounting.tilt > TILT and f.mounting.explained > TILT_EXPLAINS:
        return f"rays fit as if the camera were {math.degrees(f.mounting.tilt):.1f}° askew"
    return ""


def _slip(f: Findings) -> str:
    if f.stuck_for < STUCK:
        return "the wheels turned, and the robot stood: was it stuck, or the picture frozen?"
    if f.odometry.rest[2] > WHEELS_SLIP:
        return "the robot turns otherwise than its wheels: do they slip?"
    return ""


def _map(f: Findings) -> str:
    if f.odometry.rest[:2].max() > PATH_TORN:
        return "poses do not fit together: is the map of this floor?"
    return ""


def _late(f: Findings) -> str:
    late = f.odometry.value("late")
    if late > LATE and late > LATE_SURE * f.odometry.sd("late"):
        return f"pictures seem to come {1e3 * late:.0f} ms late"
    return ""


def _wheels(f: Findings) -> str:
    for name, limit in (("forward", RADII), ("turn_by_way", RADII_TURN)):
        value = f.odometry.value(name)
        if abs(value) > limit and abs(value) > SURE * f.odometry.sd(name):
            size = f"{100 * value:+.0f} %"
            if name == "turn_by_way":
                size = f"the robot turns by {math.degrees(value):+.0f}° a metre"
            return f"wheels seem to be of another size ({size})"
    return ""


PATTERNS: dict[Cause, Callable[[Findings], str]] = {
    Cause.MODEL: _model,
    Cause.CAMERA_ASKEW: _camera,
    Cause.WHEEL_SLIP: _slip,
    Cause.MAP: _map,
    Cause.PICTURES_LATE: _late,
    Cause.WHEEL_SIZE: _wheels,
}
