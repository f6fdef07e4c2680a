"""Floors of wood, lino, carpet and concrete, as the simulated camera sees them."""

from itertools import product

import numpy as np
import pytest

from robot.description.spec import RobotSpec
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Pose2, Twist2
from sim.floor_camera import TEXTURES, TONES, CameraSettings, FloorCamera
from sim.floor_textures import AROUND_M, add_texture

TAPE, BARE = 32, 213
KINDS = [*product(TEXTURES[1:], TONES)]


def floor() -> FloorPicture:
    """Bare floor of 0.3 m by 0.2 m with tape along x."""
    image = np.full((200, 300), BARE, dtype=np.uint8)
    image[90:140] = TAPE
    return FloorPicture(image, 0.001, (0.0, 0.0, 0.3, 0.2))


def made(kind: str, tone: str, seed: int = 0) -> FloorPicture:
    return add_texture(floor(), kind, tone, np.random.default_rng(seed))


def test_no_texture_leaves_the_floor_as_it_is():
    plain = floor()
    assert add_texture(plain, "none", "dark", np.random.default_rng(0)) is plain


@pytest.mark.parametrize(("kind", "tone"), KINDS)
def test_tape_covers_the_material_where_the_drawing_has_it(kind, tone):
    textured = made(kind, tone)
    around = round(AROUND_M / textured.resolution)
    inner = textured.image[around:-around, around:-around]
    assert textured.extent == pytest.approx((-0.5, -0.5, 0.8, 0.7))
    assert np.isclose(textured.resolution, 0.0005)
    assert (inner[182:278, 2:-2] == TAPE).all()
    assert inner[:170].std() > 2


def test_light_floors_are_lighter_than_dark_ones_and_dark_ones_than_tape():
    for kind in TEXTURES[1:]:
        light, dark = (made(kind, tone).image[:400].mean() for tone in TONES)
        assert BARE > light > 1.5 * dark > 1.5 * TAPE


def test_a_seed_draws_the_same_floor_again():
    one, same, other = (made("concrete", "light", seed).image for seed in (1, 1, 2))
    assert (one == same).all() and (one != other).any()


def test_an_unknown_floor_is_refused_and_the_valid_ones_named():
    with pytest.raises(ValueError, match="valid are none, wood, lino"):
        made("sand", "light")


def test_what_a_camera_draws_by_chance_is_the_same_with_a_texture():
    """Clutter, light and noise keep their streams: only the floor differs."""
    view = RobotSpec.load().floor_view
    robots = [np.random.default_rng(3) for _ in range(2)]
    for rng, kind in zip(robots, ("none", "lino"), strict=True):
        settings = CameraSettings(texture=kind, clutter="discs")
        FloorCamera(view, floor(), settings, rng).picture(Pose2(), Twist2())
    assert robots[0].random() == robots[1].random()
    assert robots[0].spawn(1)[0].random() == robots[1].spawn(1)[0].random()
