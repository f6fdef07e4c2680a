"""How long it takes to render a picture: our own projection, and pybullet's renderer."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from app.settings.config import MAPS
from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from sim.bullet import load_pybullet
from sim.floor_camera import CameraSettings, FloorCamera

RUNS = 40


def measure() -> Result:
    """Measure 640 x 480 px; ours has lens, anti-aliasing, motion blur, noise and vignetting."""
    spec = RobotSpec.load()
    rng = np.random.default_rng(0)
    camera = FloorCamera(spec.floor_view, load_field("square", MAPS).floor, CameraSettings(), rng)
    turns = iter(np.linspace(0, 6, RUNS + 1))

    def ours() -> None:
        camera.picture(Pose2(0.0, 0.0, float(next(turns))), Twist2(0.15, 0.8))

    return Result(
        unit="ms a picture",
        brickpose=_median_ms(ours, RUNS),
        peer={"pybullet TinyRenderer (no lens, no anti-aliasing)": _median_ms(_pybullet(), 5)},
    )


def _pybullet() -> Callable[[], None]:
    bullet = load_pybullet()
    client = bullet.connect(bullet.DIRECT)
    shape = bullet.createVisualShape(
        bullet.GEOM_BOX, halfExtents=[1, 1, 0.001], physicsClientId=client
    )
    bullet.createMultiBody(0, -1, shape, physicsClientId=client)
    view = bullet.computeViewMatrix([0, 0, 0.16], [0.23, 0, 0], [0, 0, 1])
    lens = bullet.computeProjectionMatrixFOV(48.7, 640 / 480, 0.02, 5)

    def render() -> None:
        bullet.getCameraImage(
            640, 480, view, lens, renderer=bullet.ER_TINY_RENDERER, physicsClientId=client
        )

    return render


def _median_ms(work: Callable[[], None], runs: int) -> float:
    work()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))
