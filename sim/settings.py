"""All settings of the simulated robot."""

from __future__ import annotations

from dataclasses import dataclass

from sim.bullet import BulletSettings
from sim.floor_camera import CameraSettings
from sim.imperfections import Imperfections


@dataclass(frozen=True)
class SimSettings:
    """The robot that is not there: its camera, the forces on it, and how it is not as drawn."""

    camera: CameraSettings = CameraSettings()
    physics: BulletSettings = BulletSettings()
    imperfections: Imperfections = Imperfections()
