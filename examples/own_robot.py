"""A robot of one's own: perfect wheels, no camera, and a laser for which tape is a wall."""

import numpy as np
from numpy.typing import NDArray

import brickpose as bp


class Cart:
    """A ``brickpose.Robot``: fifty readings a second, each with a scan."""

    name = "Cart"
    bearings = np.radians(np.arange(-180.0, 180.0, 4.0))

    def __init__(self) -> None:
        self.spec, self.field = bp.RobotSpec.load(), bp.load_field("square", bp.MAPS)
        self.true, self.tick = self.field.start, 0
        self.turned = self.speeds = np.zeros(2)

    def read(self) -> bp.Reading:
        self.tick, self.turned = self.tick + 1, self.turned + 0.02 * self.speeds
        left, right = (0.02 * self.spec.wheel_radius * self.speeds).tolist()
        self.true = self.true @ bp.Pose2((left + right) / 2, 0.0, (right - left) / self.spec.track)
        (ranges,) = self.field.ranges(self.true.to_array()[None], self.bearings, range_max=2.0)
        scan = bp.Scan(0.02 * self.tick, self.bearings, ranges)
        return bp.Reading(0.02 * self.tick, self.turned, self.speeds, scan=scan, truth=self.true)

    def write(self, velocities: NDArray[np.float64]) -> NDArray[np.float64]:
        self.speeds = np.clip(velocities, -10.0, 10.0)
        return self.speeds

    def close(self) -> None:
        self.speeds = np.zeros(2)


program = bp.build_program(bp.Config(map="square"), robot=Cart())
for _ in range(250):
    program.engine.commands.put(bp.DriveCommand(type="drive", v=0.1, omega=0.8))
    snapshot = program.engine.step()
print(snapshot.pose, snapshot.truth, snapshot.integrity.state)
