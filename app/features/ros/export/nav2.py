"""Parameters of nav2 for this robot: amcl, map server, costmaps, controller, planner."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.fields.field import Field

AMCL_MODELS = {
    "differential": "nav2_amcl::DifferentialMotionModel",
    "omni": "nav2_amcl::OmniMotionModel",
}
"""The motion models of BrickPose that nav2 also has."""

AMCL_NAMES = (
    "alpha1", "alpha2", "alpha3", "alpha4", "alpha5",
    "beam_skip_distance", "beam_skip_error_threshold", "beam_skip_threshold", "do_beamskip",
    "lambda_short", "laser_likelihood_max_dist", "laser_min_range", "laser_model_type",
    "max_beams", "max_particles", "min_particles", "pf_err", "pf_z",
    "recovery_alpha_fast", "recovery_alpha_slow", "resample_interval",
    "sigma_hit", "update_min_a", "update_min_d", "z_hit", "z_max", "z_rand", "z_short",
)  # fmt: skip
"""Parameters of the same name and meaning in nav2_amcl and here."""

AHEAD_S = 1.5
"""Lookahead time of the pure pursuit [s]: times the speed, it gives the lookahead distance."""


def nav2(spec: RobotSpec, config: Config, field: Field) -> dict[str, Any]:
    """The parameters of each node, as ``nav2_bringup`` reads them."""
    nodes = {
        "amcl": amcl(config, field),
        "map_server": {"yaml_filename": f"maps/{field.name}.yaml"},
        "controller_server": _controller(spec, config),
        "planner_server": {
            "planner_plugins": ["GridBased"],
            "GridBased": {"plugin": "nav2_navfn_planner::NavfnPlanner", "tolerance": 0.05},
        },
        "velocity_smoother": _smoother(spec, config),
    }
    around = {name: {"ros__parameters": values} for name, values in nodes.items()}
    for name in ("local_costmap", "global_costmap"):
        around[name] = {name: {"ros__parameters": _costmap(name, spec, config)}}
    return around


def amcl(config: Config, field: Field) -> dict[str, Any]:
    """nav2_amcl's parameters, with the values of this program's filter."""
    ros2, start = config.ros2, field.start
    ours: dict[str, Any] = {}
    for group in dataclasses.fields(config.localization):
        ours |= dataclasses.asdict(getattr(config.localization, group.name))
    result = {name: ours[name] for name in AMCL_NAMES}
    kind = str(ours["robot_model_type"])
    return result | {
        "robot_model_type": AMCL_MODELS.get(kind, AMCL_MODELS["differential"]),
        "laser_max_range": config.scanner.range_max,
        "base_frame_id": ros2.base_frame_id,
        "odom_frame_id": ros2.odom_frame_id,
        "global_frame_id": ros2.global_frame_id,
        "scan_topic": "scan",
        "map_topic": "map",
        "tf_broadcast": True,
        "set_initial_pose": True,
        "initial_pose": {"x": start.x, "y": start.y, "z": 0.0, "yaw": start.theta},
    }


def _limits(spec: RobotSpec, config: Config) -> tuple[float, float]:
    drive = config.drive
    top_omega = min(drive.max_angular_velocity, spec.max_omega)
    return min(drive.max_velocity, spec.max_v), top_omega


def _controller(spec: RobotSpec, config: Config) -> dict[str, Any]:
    top_v, _ = _limits(spec, config)
    follow = {
        "plugin": "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
        "desired_linear_vel": top_v,
        "lookahead_dist": round(AHEAD_S * top_v, 3),
        "max_angular_accel": config.drive.max_angular_acceleration,
        "use_rotate_to_heading": True,
    }
    return {
        "controller_frequency": config.ros2.publish_rate,
        "progress_checker_plugins": ["progress_checker"],
        "progress_checker": {
            "plugin": "nav2_controller::SimpleProgressChecker",
            "required_movement_radius": 0.05,
        },
        "goal_checker_plugins": ["goal_checker"],
        "goal_checker": {
            "plugin": "nav2_controller::SimpleGoalChecker",
            "xy_goal_tolerance": 0.02,
            "yaw_goal_tolerance": 0.1,
        },
        "controller_plugins": ["FollowPath"],
        "FollowPath": follow,
    }


def _smoother(spec: RobotSpec, config: Config) -> dict[str, Any]:
    (top_v, top_omega), drive = _limits(spec, config), config.drive
    return {
        "max_velocity": [top_v, 0.0, top_omega],
        "min_velocity": [-top_v, 0.0, -top_omega],
        "max_accel": [drive.max_acceleration, 0.0, drive.max_angular_acceleration],
        "max_decel": [-drive.max_deceleration, 0.0, -drive.max_angular_deceleration],
        "velocity_timeout": drive.cmd_vel_timeout,
        "enable_stamped_cmd_vel": config.ros2.stamped_cmd_vel,
    }


def _costmap(name: str, spec: RobotSpec, config: Config) -> dict[str, Any]:
    corners = ", ".join(f"[{x:.4f}, {y:.4f}]" for x, y in spec.outline.tolist())
    farthest = max(math.hypot(x, y) for x, y in spec.outline.tolist())
    ros2, local = config.ros2, name == "local_costmap"
    shared = {
        "global_frame": ros2.odom_frame_id if local else ros2.global_frame_id,
        "robot_base_frame": ros2.base_frame_id,
        "footprint": f"[{corners}]",
        "resolution": ros2.map_resolution,
        "inflation_layer": {
            "plugin": "nav2_costmap_2d::InflationLayer",
            "inflation_radius": round(2 * farthest, 3),
        },
    }
    if local:
        rolling = {"rolling_window": True, "width": 1, "height": 1}
        return shared | rolling | {"plugins": ["inflation_layer"]}
    static = {"plugin": "nav2_costmap_2d::StaticLayer", "map_subscribe_transient_local": True}
    return shared | {"plugins": ["static_layer", "inflation_layer"], "static_layer": static}
