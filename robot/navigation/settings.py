"""NavigationSettings: how goals are driven to, by nav2's names where nav2 has the same."""

from __future__ import annotations

from dataclasses import dataclass

from robot.settings import SettingError, check_settings, setting

TAPE = ("wall", "ignored")
TOLD, REFUSED = "told", "refused"
"""What becomes of ways that come nearer to walls than the bound of the robot's place."""


@dataclass(frozen=True)
class NavigationSettings:
    """How the robot drives to a goal."""

    planner: str = setting(
        "grid", "Finds ways: grid, lattice, rrt, that of a package, or FILE.py:NAME of your own"
    )
    controller: str = setting(
        "tracker",
        "Drives along them: tracker, pursuit, that of a package, or FILE.py:NAME of your own",
    )
    tape: str = setting(
        "wall", "Whether tape is a wall that the robot does not touch, or ignored", choices=TAPE
    )
    resolution: float = setting(
        0.005, "Side of a cell of the planner's grid", unit="m", low=0.002, high=0.1
    )
    clearance: float = setting(
        0.008, "Room between the robot's outline and walls", unit="m", low=0, high=0.5
    )
    inflation_radius: float = setting(
        0.25, "Paths keep away from walls that are nearer than this", unit="m", low=0, high=2
    )
    cost_scaling_factor: float = setting(
        20.0, "How soon the cost of a wall falls with its distance", unit="1/m", low=0.1, high=200
    )
    smoothing: float = setting(
        0.10, "A corner of the path is rounded over this length", unit="m", low=0, high=1
    )
    desired_linear_vel: float = setting(
        0.20, "Speed along the path where nothing asks for less", unit="m/s", low=0.01, high=2
    )
    rotate_to_heading_angular_vel: float = setting(
        1.8, "Turning speed on the spot", unit="rad/s", low=0.05, high=20
    )
    max_angular_accel: float = setting(
        3.2, "Turning speed gained or lost in a second", unit="rad/s^2", low=0.05, high=200
    )
    lookahead_dist: float = setting(
        0.04, "Way on which the robot comes back to its path", unit="m", low=0.02, high=1
    )
    minimum_turning_radius: float = setting(
        0.12, "Smallest radius of a bend, of the planner lattice", unit="m", low=0.02, high=5
    )
    lookahead_time: float = setting(
        0.45, "Look-ahead over speed, of the controller pursuit", unit="s", low=0.05, high=5
    )
    min_lookahead_dist: float = setting(
        0.05, "Shortest look-ahead, of the controller pursuit", unit="m", low=0.01, high=2
    )
    max_lookahead_dist: float = setting(
        0.15, "Longest look-ahead, of the controller pursuit", unit="m", low=0.01, high=5
    )
    regulated_linear_scaling_min_radius: float = setting(
        0.20, "Pursuit drives slower in bends of a smaller radius", unit="m", low=0, high=10
    )
    regulated_linear_scaling_min_speed: float = setting(
        0.05, "Pursuit drives no slower in bends", unit="m/s", low=0.005, high=2
    )
    approach_velocity_scaling_dist: float = setting(
        0.12, "Pursuit slows down over this length at the end", unit="m", low=0.01, high=5
    )
    min_approach_linear_velocity: float = setting(
        0.02, "Pursuit drives no slower at the end", unit="m/s", low=0.005, high=1
    )
    command_lag: float = setting(
        0.10, "Time after which the wheels turn as they are told", unit="s", low=0, high=1
    )
    xy_goal_tolerance: float = setting(
        0.001, "Largest distance from the goal at the end", unit="m", low=0.0002, high=1
    )
    yaw_goal_tolerance: float = setting(
        0.004, "Largest difference from the goal's heading", unit="rad", low=0.0005, high=3.2
    )
    slow_radius: float = setting(
        0.05, "The robot slows down while its bound is wider than this", unit="m", low=0.001, high=1
    )
    stop_radius: float = setting(
        0.15,
        "The robot looks around while its bound is wider than this",
        unit="m",
        low=0.002,
        high=2,
    )
    narrow_ways: str = setting(
        TOLD,
        "Ways nearer to walls than the robot's bound, where no other is found: driven and told, or "
        "refused",
        choices=(TOLD, REFUSED),
    )
    off_path: float = setting(
        0.05, "A robot that is farther from its path plans anew", unit="m", low=0.005, high=2
    )

    def __post_init__(self) -> None:
        check_settings(self)
        if self.stop_radius <= self.slow_radius:
            raise SettingError(
                f"stop_radius is {self.stop_radius} m; valid is more than slow_radius"
            )
        if self.max_lookahead_dist < self.min_lookahead_dist:
            raise SettingError(
                f"max_lookahead_dist is {self.max_lookahead_dist} m; valid is min_lookahead_dist "
                "or more"
            )
