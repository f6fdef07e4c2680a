"""What a ray saw is shown as it was: brightness, and how the edge kernel responds to it."""

import numpy as np
from tape_trials import SCANNER, SQUARE, STILL, camera_of

from app.features.weighing.ray_profile import along_rays, profile
from robot.geometry import Pose2
from robot.interface import Frame
from sim.floor_camera import CameraSettings

RAY = 45


def test_what_the_rays_saw_is_kept_to_be_shown():
    camera = camera_of(SQUARE, CameraSettings())
    found = SCANNER.scan(Frame(0.0, camera.picture(Pose2(), STILL)))
    entry, leave = (round(edge) for edge in found.edges[RAY])
    used = SCANNER.table.counts[RAY]
    grey, response = along_rays(found)
    assert grey.shape == response.shape == SCANNER.table.distances.shape
    assert grey[RAY, (entry + leave) // 2] < 80
    assert grey[RAY, 20] > 150
    along = response[RAY, :used]
    assert abs(int(along.argmin()) - entry) <= 1 and abs(int(along.argmax()) - leave) <= 1
    assert -200 < along.min() < -60 and 60 < along.max() < 200
    shown = profile(SCANNER, found, RAY)
    assert shown.counted and shown.grey == grey[RAY, :used].tolist()
    assert np.abs(np.array(shown.response) - along).max() < 0.06
