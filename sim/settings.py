"""All settings of the simulated robot."""

from __future__ import annotations

from dataclasses import dataclass

from sim.bullet import BulletSettings
from sim.floor_camera import CameraSettings
from sim.imperfections import Imperfections


@dataclass(frozen=True)
class SimSettings:
    """Settings of the simulated robot: its camera, its physics, and its imperfections."""

    camera: CameraSettings = CameraSettings()
    physics: BulletSettings = BulletSettings()
    imperfections: Imperfections = Imperfections()
