"""The list of all topics; names, types and frames follow nav2, diff_drive_controller and RViz."""

from __future__ import annotations

from app.ros2.encoding import motion, robot_state, sensors
from app.ros2.topic import LATCHED, Topic

TOPICS: tuple[Topic, ...] = (
    Topic("scan", "sensor_msgs/msg/LaserScan", sensors.scan_stamp, sensors.laser_scan),
    Topic("odom", "nav_msgs/msg/Odometry", motion.tick_stamp, motion.odometry, "publish_rate"),
    Topic("tf", "tf2_msgs/msg/TFMessage", motion.tick_stamp, motion.transforms, "publish_rate"),
    Topic(
        "tf_static",
        "tf2_msgs/msg/TFMessage",
        motion.calibration_stamp,
        motion.static_transforms,
        quality=LATCHED,
    ),
    Topic(
        "amcl_pose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        motion.estimate_stamp,
        motion.amcl_pose,
        quality=LATCHED,
    ),
    Topic(
        "particle_cloud",
        "nav2_msgs/msg/ParticleCloud",
        motion.tick_stamp,
        motion.particle_cloud,
        "cloud_rate",
    ),
    Topic(
        "particlecloud",
        "geometry_msgs/msg/PoseArray",
        motion.tick_stamp,
        motion.pose_array,
        "cloud_rate",
    ),
    Topic(
        "map",
        "nav_msgs/msg/OccupancyGrid",
        sensors.map_stamp,
        sensors.occupancy_grid,
        quality=LATCHED,
    ),
    Topic(
        "joint_states",
        "sensor_msgs/msg/JointState",
        motion.tick_stamp,
        motion.joint_states,
        "publish_rate",
    ),
    Topic(
        "camera/image/compressed",
        "sensor_msgs/msg/CompressedImage",
        sensors.picture_stamp,
        sensors.compressed_image,
        "picture_rate",
    ),
    Topic(
        "camera/camera_info",
        "sensor_msgs/msg/CameraInfo",
        sensors.picture_stamp,
        sensors.camera_info,
        "picture_rate",
    ),
    Topic(
        "robot_description",
        "std_msgs/msg/String",
        motion.calibration_stamp,
        robot_state.robot_description,
        quality=LATCHED,
    ),
    Topic(
        "battery_state",
        "sensor_msgs/msg/BatteryState",
        robot_state.battery_stamp,
        robot_state.battery_state,
    ),
    Topic(
        "diagnostics",
        "diagnostic_msgs/msg/DiagnosticArray",
        motion.each_second,
        robot_state.diagnostics,
    ),
    Topic(
        "truth",
        "geometry_msgs/msg/PoseStamped",
        motion.truth_stamp,
        motion.true_pose,
        "publish_rate",
    ),
    Topic(
        "cmd_vel",
        "geometry_msgs/msg/TwistStamped",
        motion.tick_stamp,
        motion.applied_velocity,
        live=False,
    ),
    Topic(
        "initialpose",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        robot_state.initial_pose_stamp,
        robot_state.initial_pose,
        live=False,
    ),
    Topic(
        "command",
        "std_msgs/msg/String",
        robot_state.told_stamp,
        robot_state.commands_as_json,
        live=False,
    ),
)
