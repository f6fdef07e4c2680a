"""``follow``: the velocity that keeps a robot on its trajectory."""

from __future__ import annotations

import math

from robot.geometry import Pose2, Twist2
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Wanted

ALONG_GAIN = 3.0
"""Speed by how far the robot is behind [1/s]."""
TURN_GAIN = 4.0
"""Turning speed by the difference of headings, at rest [1/s]."""
MOST_CATCH_UP, MOST_TURN = 0.08, 0.8
"""Feedback changes the wanted twist by at most this [m/s, rad/s]."""


def follow(pose: Pose2, wanted: Wanted, ahead: Twist2, settings: NavigationSettings) -> Twist2:
    """Return the twist to command (Kanayama et al. 1990, with gains by the way).

    The wanted twist is driven; what the robot is off is added: ahead of it by speed, sideways by
    turning as it drives, so that it is back after ``lookahead_dist``, and its heading by turning.

    Args:
        pose: of the robot.
        wanted: what is wanted now.
        ahead: the twist that is wanted when the command takes effect.
        settings: has ``lookahead_dist``.
    """
    error = pose.inverse() @ wanted.pose
    back = 1.0 / settings.lookahead_dist
    rate = abs(ahead.v) * back
    catch_up = _limited(ALONG_GAIN * error.x, MOST_CATCH_UP)
    sideways = ahead.v * back * back * error.y
    turning = (max(2 * rate, TURN_GAIN)) * error.theta
    v = ahead.v * math.cos(error.theta) + catch_up
    return Twist2(v, ahead.omega + _limited(sideways + turning, MOST_TURN))


def _limited(value: float, most: float) -> float:
    return min(max(value, -most), most)
