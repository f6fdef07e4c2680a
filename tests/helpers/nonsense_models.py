"""Sensor models as students write them first, good and wrong."""

GOOD = """
import numpy as np


class Model:
    scale, degrees = 1.0, False

    def __init__(self, field):
        self.starts, self.ways = field.edges[:, :2], field.edges[:, 2:] - field.edges[:, :2]

    def log_likelihood(self, poses, scan):
        x, y = scan.points()[::5].T
        heading = np.degrees(poses[:, 2:]) if self.degrees else poses[:, 2:]
        c, s = np.cos(heading), np.sin(heading)
        ends = np.stack([c * x - s * y, s * x + c * y], axis=2) + poses[:, None, :2]
        off = np.full(ends.shape[:2], 0.03)
        for start, way in zip(self.starts, self.ways):
            along = np.clip((ends - start) @ way / (way @ way), 0, 1)
            off = np.minimum(off, np.linalg.norm(ends - start - along[..., None] * way, axis=2))
        return self.answer(-0.5 * ((self.scale * off / 0.004) ** 2).sum(axis=1))

    def answer(self, log_likelihood):
        return log_likelihood
"""

NONSENSE = {
    "a constant": "    def answer(self, log_likelihood):\n        return 0 * log_likelihood\n",
    "the likelihood for its logarithm": (
        "    def answer(self, log_likelihood):\n        return np.exp(log_likelihood)\n"
    ),
    "its opposite": "    def answer(self, log_likelihood):\n        return -log_likelihood\n",
    "degrees for radians": "    degrees = True\n",
    "metres for millimetres": "    scale = 0.001\n",
}
