"""Things on the floor: where they should be, the same for a seed, and told by name."""

from __future__ import annotations

import numpy as np
import pytest
from tape_trials import SQUARE, STILL, VIEW

from robot.geometry import Pose2
from sim.clutter import CLUTTER, SHADOW, add_clutter
from sim.floor_camera import KINDS, CameraSettings, FloorCamera

FLOOR = SQUARE.floor


def test_settings_name_each_kind() -> None:
    assert ("none", *CLUTTER, "all") == KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_clutter_is_the_same_for_a_seed_and_leaves_the_floor_alone(kind: str) -> None:
    before = FLOOR.image.copy()
    first, again = (add_clutter(FLOOR, kind, np.random.default_rng(3)) for _ in range(2))
    other = add_clutter(FLOOR, kind, np.random.default_rng(4))
    np.testing.assert_array_equal(first.image, again.image)
    assert (first.image.tobytes() == other.image.tobytes()) == (kind == "none")
    np.testing.assert_array_equal(FLOOR.image, before)
    assert first.extent == FLOOR.extent and first.resolution == FLOOR.resolution


@pytest.mark.parametrize("kind", CLUTTER)
def test_things_are_darker_than_the_floor(kind: str) -> None:
    changed = add_clutter(FLOOR, kind, np.random.default_rng(0)).image.astype(int) - FLOOR.image
    share = (changed < -20).mean()
    assert changed.max() <= 5
    least, most = {
        "discs": (0.008, 0.035), "cable": (0.003, 0.01), "shadow": (0.2, 0.8), "shoes": (0.01, 0.08)
    }[kind]  # fmt: skip
    assert least < share < most


def test_a_shadow_takes_its_share_of_the_light_softly() -> None:
    shaded = add_clutter(FLOOR, "shadow", np.random.default_rng(0)).image
    ratio = shaded.astype(float) / np.maximum(FLOOR.image, 1)
    light = FLOOR.image > 150
    assert ratio[light].min() == pytest.approx(SHADOW, abs=0.01) and ratio[light].max() == 1
    assert ((ratio[light] > 0.6) & (ratio[light] < 0.95)).any()


def test_discs_lie_between_the_tapes_and_shoes_at_the_border() -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        discs = np.argwhere(add_clutter(FLOOR, "discs", rng).image < FLOOR.image - 20.0)
        assert np.abs(discs - 750).max() < 462
        shoes = np.argwhere(add_clutter(FLOOR, "shoes", rng).image < FLOOR.image - 20.0)
        assert np.abs(shoes - 750).max(axis=1).min() > 440


def test_an_unknown_kind_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="no clutter 'cats'; valid are none, discs"):
        add_clutter(FLOOR, "cats", np.random.default_rng(0))
    with pytest.raises(ValueError, match="clutter is 'cats'"):
        CameraSettings(clutter="cats")


def test_a_camera_sees_clutter_with_the_noise_it_has_without() -> None:
    def picture(kind: str) -> np.ndarray:
        rng = np.random.default_rng(1)
        camera = FloorCamera(VIEW, FLOOR, CameraSettings(clutter=kind), rng)
        return camera.picture(Pose2(), STILL).astype(int)

    plain, shoes, discs = (picture(kind) for kind in ("none", "shoes", "discs"))
    assert (plain - discs > 60).mean() > 0.002
    assert (plain == shoes).mean() > 0.5, "where nothing lies, all is as it was"
