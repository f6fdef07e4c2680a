"""A synthetic office, a robot with a laser in it, and its bags."""

import functools

import numpy as np

from app.features.lab.localize.laser_map import LaserMap
from benchmarks.lasers.laser_bags import LaserBag
from benchmarks.lasers.laser_robot import Laser, wander
from robot.fields.grid_map import save_map_yaml
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2

CELL = 0.05
BEGAN = 1000.25
LASER = Laser(beams=180, reach=12.0)
SECONDS = 12.0
START = Pose2(2.0, 1.6, 0.3)
"""In the cells' frame."""
ORIGIN = Pose2(-3.0, 2.0, 0.4)


def office(origin=ORIGIN):
    """Rooms of different sizes (12 m x 8 m) with things in them; unknown around."""
    height, width = 160, 240
    cells = np.full((height, width), -1, dtype=np.int8)
    cells[10:150, 10:230] = 0
    cells[[10, 150], 10:231] = 100
    cells[10:151, [10, 230]] = 100
    cells[10:90, 110] = 100
    cells[30:50, 110] = 0
    cells[90, 10:180] = 100
    cells[90, 60:85] = 0
    cells[90, 140:160] = 0
    cells[60:66, 40:70] = 100
    cells[20:40, 180:190] = 100
    cells[120:124, 120:150] = 100
    cells[100:112, 200:206] = 100
    return OccupancyGrid(cells, CELL, origin)


@functools.cache
def office_map():
    return LaserMap.of(office(), "office")


@functools.cache
def drive(laser=LASER, seconds=SECONDS, seed=0):
    """What a robot sees that wanders through it."""
    return tuple(wander(office_map(), laser, seconds, seed, START))


def true_pose(one):
    """In the map."""
    return office_map().pose_in_map(one.truth)


def write_map(folder):
    path = folder / "office.yaml"
    save_map_yaml(office(), path)
    return path


def write_bag(path, kind="mcap", *, seen=None, laser=LASER, mounted=True, odometry="topic", **scan):
    """The drive as a bag; odometry from a topic, or from tf alone."""
    with LaserBag(path, kind) as bag:
        if mounted:
            bag.transform(BEGAN, "base_link", "laser", laser.place, topic="/tf_static")
        for one in drive(laser) if seen is None else seen:
            stamp = BEGAN + one.stamp
            if odometry == "topic":
                bag.odometry(stamp, one.odometry)
            else:
                bag.transform(stamp, "/odom", "/base_link", one.odometry)
            form = {"first": laser.bearings[0], "step": laser.step, "reach": (0.05, laser.reach)}
            bag.scan(stamp, one.ranges, **(form | scan))
    return path
