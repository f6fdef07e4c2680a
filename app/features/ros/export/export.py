"""Exports a folder that makes this robot an ordinary one of ROS 2: URDF, controller, nav2.

All of it comes from the robot's description and the settings.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

import yaml

from app.console import say
from app.engine.robots import robot_spec
from app.features.ros.encoding.motion import POSE_VARIANCE, TWIST_VARIANCE
from app.features.ros.export.nav2 import nav2
from app.options import config_of
from app.result_files import make_folder
from app.settings.config import MAPS, Config
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml
from robot.fields.field_loading import load_field
from robot.fields.grid_map import save_map_yaml
from robot.lens_files.camera_info import camera_info

UPDATE_HZ = 100
UNUSED_VARIANCE = 1e6
"""Variance of the motions that a robot on a floor does not make: z, roll and pitch."""
TITLE = "By `brickpose export ros2`, from the robot's description, profile and settings."
MOCK = "mock_components/GenericSystem"
"""ros2_control's own mock of hardware: its wheels follow each command at once."""


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


def export_ros2(folder: Path, config: Config, plugin: str = MOCK) -> list[Path]:
    """Write description, parameters and map; return the paths of the files.

    Args:
        folder: where to write them; made if it does not exist.
        plugin: ros2_control's hardware plugin for the wheels.

    Raises:
        SettingError: the folder cannot be made.
        SpecError: the robot's profile cannot be used.
        OSError: a file cannot be written.
    """
    spec, field = robot_spec(config), load_field(config.map, MAPS)
    for name in ("urdf", "config", "maps"):
        make_folder(folder / name)
    lens = _lens_file(spec)
    grid = field.grid or field.occupancy(config.ros2.map_resolution)
    files = {
        folder / "urdf" / "brickpose.urdf": with_plugin(spec.urdf, plugin),
        folder / "urdf" / lens: camera_info(spec.lens, title=TITLE),
        folder / "config" / "controllers.yaml": _yaml(controllers(spec, config)),
        folder / "config" / "nav2.yaml": _yaml(nav2(spec, config, field)),
    }
    for path, text in files.items():
        path.write_text(text, encoding="utf-8")
    chart = folder / "maps" / f"{field.name}.yaml"
    save_map_yaml(grid, chart)
    return [*files, chart, chart.with_suffix(".pgm")]


def with_plugin(urdf: str, plugin: str) -> str:
    """Replace the description's ros2_control hardware plugin for the wheels."""
    parse_xml(urdf)
    before, tag, after = urdf.partition("<plugin>")
    _, end, rest = after.partition("</plugin>")
    return before + tag + plugin + end + rest


def _lens_file(spec: RobotSpec) -> str:
    named = parse_xml(spec.urdf).find("ros2_control/sensor/param[@name='camera_info']")
    assert named is not None and named.text  # every RobotSpec has a camera
    return named.text.strip()


def _yaml(content: dict[str, Any]) -> str:
    written: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)
    return f"# {TITLE}\n{written}"


def export_command(parsed: argparse.Namespace) -> int:
    """Write the files, and print their paths."""
    given = vars(parsed)
    for path in export_ros2(parsed.folder, config_of(given), given.get("hardware_plugin", MOCK)):
        say(str(path))
    return 0
