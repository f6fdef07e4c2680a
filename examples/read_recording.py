"""Read a recording with a package that everybody has, and say how far the robot drove.

python read_recording.py recordings/NAME
"""

import math
import sys
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader

with AnyReader([Path(sys.argv[1])]) as bag:
    points = []
    for connection, _, data in bag.messages():
        if connection.topic == "/odom":
            odometry: Any = bag.deserialize(data, connection.msgtype)
            position = odometry.pose.pose.position
            points.append((position.x, position.y))
way = sum(math.dist(a, b) for a, b in zip(points, points[1:], strict=False))
print(f"{len(points)} poses by the wheels, {way:.2f} m")
