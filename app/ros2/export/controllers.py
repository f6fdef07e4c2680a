"""Parameters for ros2_control: diff_drive_controller with this robot's dimensions and limits."""

from __future__ import annotations

import math
from typing import Any

from app.ros2.encoding.motion import POSE_VARIANCE, TWIST_VARIANCE
from app.settings.config import Config
from robot.description.spec import RobotSpec

UPDATE_HZ = 100
UNUSED_VARIANCE = 1e6
"""Variance of the motions that a robot on a floor does not make: z, roll and pitch."""


def controllers(spec: RobotSpec, config: Config) -> dict[str, Any]:
    """The parameters as ``ros2_control_node`` reads them (in Jazzy, .nan means no limit)."""
    manager = {
        "update_rate": UPDATE_HZ,
        "joint_state_broadcaster": {"type": "joint_state_broadcaster/JointStateBroadcaster"},
        "diff_drive_controller": {"type": "diff_drive_controller/DiffDriveController"},
    }
    return {
        "controller_manager": {"ros__parameters": manager},
        "diff_drive_controller": {"ros__parameters": diff_drive(spec, config)},
    }


def diff_drive(spec: RobotSpec, config: Config) -> dict[str, Any]:
    """The parameters of diff_drive_controller."""
    drive, ros2 = config.drive, config.ros2
    left, right = spec.axle
    # The controller has one radius; where the wheels differ, the multipliers say so.
    ratios = {side: spec.joints[side].radius / spec.wheel_radius for side in (left, right)}
    top_v = min(drive.max_velocity, spec.max_v)
    top_omega = min(drive.max_angular_velocity, spec.max_omega)
    return {
        "left_wheel_names": [spec.joints[left].name],
        "right_wheel_names": [spec.joints[right].name],
        "wheel_separation": spec.track,
        "wheel_radius": spec.wheel_radius,
        "wheel_separation_multiplier": drive.wheel_separation_multiplier,
        "left_wheel_radius_multiplier": ratios[left] * drive.left_wheel_radius_multiplier,
        "right_wheel_radius_multiplier": ratios[right] * drive.right_wheel_radius_multiplier,
        "odom_frame_id": ros2.odom_frame_id,
        "base_frame_id": ros2.base_frame_id,
        "pose_covariance_diagonal": _in_space(POSE_VARIANCE),
        "twist_covariance_diagonal": _in_space(TWIST_VARIANCE),
        "open_loop": False,
        "position_feedback": True,
        "enable_odom_tf": True,
        "cmd_vel_timeout": drive.cmd_vel_timeout,
        "publish_rate": ros2.publish_rate,
        "linear": {"x": _limits(top_v, drive.max_acceleration, drive.max_deceleration)},
        "angular": {
            "z": _limits(top_omega, drive.max_angular_acceleration, drive.max_angular_deceleration)
        },
    }


def _limits(velocity: float, acceleration: float, deceleration: float) -> dict[str, float]:
    """The same limits in both directions, with the signs that the controller expects."""
    return {
        "max_velocity": velocity,
        "min_velocity": -velocity,
        "max_acceleration": acceleration,
        "max_deceleration": -deceleration,
        "max_acceleration_reverse": -acceleration,
        "max_deceleration_reverse": deceleration,
        "max_jerk": math.nan,
        "min_jerk": math.nan,
    }


def _in_space(variance: tuple[float, float, float]) -> list[float]:
    x, y, theta = variance
    return [x, y, UNUSED_VARIANCE, UNUSED_VARIANCE, UNUSED_VARIANCE, theta]
