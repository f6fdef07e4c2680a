"""How clear a picture is, and what that means for tape in a ray's way."""

from __future__ import annotations

import numpy as np
import pytest
from tape_trials import SCANNER, SQUARE, STILL, camera_of, expected

from robot.geometry import Array, Pose2
from robot.interface import Frame
from robot.scanning.picture_noise import clearness, kernel_for
from sim.floor_camera import CameraSettings

THRESHOLD = 25.0


def clear(level: float, noise: float) -> float:
    """Of a ray over floor of a grey level, in a picture of so much noise."""
    grey = np.full((1, 200), level, dtype=np.int16)
    half, weakest = kernel_for(noise, 2, THRESHOLD)
    found = clearness(grey, np.array([200], dtype=np.int32), noise, half, weakest)
    return float(found[0])


def test_a_clear_picture_is_and_the_dark_is_not() -> None:
    assert clear(215, 3) > 0.999 and clear(215, 0) > 0.999
    assert clear(20, 3) < 0.01
    assert clear(215, 60) < 0.2


def test_it_rises_with_light_and_falls_with_noise() -> None:
    by_light = [clear(level, 10) for level in range(10, 250, 10)]
    assert (np.diff(by_light) >= 0).all() and by_light[0] < 0.01 and by_light[-1] > 0.99
    by_noise = [clear(120, noise) for noise in range(3, 60, 3)]
    assert (np.diff(by_noise) <= 1e-9).all() and by_noise[0] > 0.99 and by_noise[-1] < 0.1


def test_each_ray_has_its_own_light_and_out_of_sight_is_nothing() -> None:
    grey = np.array([[200] * 50, [30] * 50, [200] * 50], dtype=np.int16)
    counts = np.array([50, 50, 0], dtype=np.int32)
    light, dark, none = clearness(grey, counts, 5.0, 2, THRESHOLD).tolist()
    assert light > 0.99 and dark < 0.1 and none == 0


def shares(settings: CameraSettings) -> tuple[float, float]:
    """Of rays that should meet tape, how many do, and how many say that they should."""
    camera, hit, said = camera_of(SQUARE, settings), [], []
    for values in SQUARE.free_poses(np.random.default_rng(0), 30):
        robot = Pose2.from_array(values)
        scan = SCANNER.scan(Frame(0.0, camera.picture(robot, STILL))).scan
        due = crossed_in_sight(robot)
        assert scan.clear is not None
        hit.append(scan.hit[due])
        said.append(scan.clear[due])
    return float(np.concatenate(hit).mean()), float(np.concatenate(said).mean())


def crossed_in_sight(robot: Pose2) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Rays that meet a side well in sight, away from corners."""
    begins, ends = expected(SQUARE, robot)
    near, far = SCANNER.table.limits.T
    bearings = SCANNER.table.bearings + robot.theta
    reach = np.nan_to_num(begins, posinf=9.0)
    met: Array = np.column_stack([robot.x + reach * np.cos(bearings),
                                  robot.y + reach * np.sin(bearings)])  # fmt: skip
    with np.errstate(invalid="ignore"):
        in_sight = (begins > near + 0.02) & (ends < far - 0.03) & (ends - begins < 0.1)
    found: np.ndarray[tuple[int], np.dtype[np.bool_]] = in_sight & (np.abs(met).min(axis=1) < 0.4)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("noise", "light"), [(3, 1), (15, 1), (30, 1), (40, 1), (3, 0.3), (10, 0.5), (5, 0.15)]
)
def test_pictures_say_what_share_of_rays_returns(noise: float, light: float) -> None:
    """The evidence of a miss counts for as much as the picture lets it."""
    returned, said = shares(CameraSettings(noise=noise, light=light))
    assert said == pytest.approx(returned, abs=0.15)


@pytest.mark.slow
def test_on_light_carpet_tape_is_found_and_misses_count_as_they_should() -> None:
    """Its grain is coarser than pixels: it was no noise, and one ray of eight returned."""
    returned, said = shares(CameraSettings(texture="carpet", tone="light"))
    assert returned > 0.95
    assert said == pytest.approx(returned, abs=0.15)
