"""A sensor model of one's own for a drive: how far do rays end from the tape's nearest edge?"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates

from brickpose import Config, Field, FigureEightCommand, Scan, build_program

CELL = 0.002  # [m]


class DistanceField:
    """A likelihood field (Probabilistic Robotics, Table 6.3) of distances to the tape."""

    def __init__(self, field: Field) -> None:
        tape = field.occupancy(CELL).occupied
        self.distance = CELL * (distance_transform_edt(~tape) + distance_transform_edt(tape))
        self.low = np.array(field.extent[:2])[:, None, None]

    def log_likelihood(self, poses: NDArray[np.float64], scan: Scan) -> NDArray[np.float64]:
        """Return the log-likelihood of a scan at poses (n, 3), as (n,)."""
        x, y = scan.points()[::2].T
        c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        ends = poses[:, :2].T[:, :, None] + [c * x - s * y, s * x + c * y]
        cells = ((ends - self.low) / CELL - 0.5)[::-1]
        error = map_coordinates(self.distance, cells, order=1, mode="nearest")
        likelihood = 0.95 * np.exp(-(error**2) / (0.005**2 + scan.extra_sd**2)) + 0.05
        return np.asarray(np.log(likelihood).sum(axis=1))


if __name__ == "__main__":
    config = Config(map="stub", seed=1, sensor_model=f"{Path(__file__)}:DistanceField")
    program = build_program(config)
    for _ in range(250):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        snapshot = program.engine.step()
    print(snapshot.pose, snapshot.truth, snapshot.integrity.state)
    program.robot.close()
