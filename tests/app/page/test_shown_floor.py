"""On the page, floor that nobody has looked at is hatched, and the rest is as it is."""

from dataclasses import replace

import numpy as np

from app.page.shown_floor import DARKER, shown_floor
from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.fields.unseen_floor import REACH, SIDE

SQUARE = load_field("square", MAPS)


def test_a_field_that_is_known_is_shown_as_it_is():
    assert shown_floor(SQUARE) is SQUARE.floor.image


def test_unseen_floor_is_hatched_to_the_right_of_what_was_seen():
    xmin, ymin, _, ymax = SQUARE.floor.extent
    seen = np.array([[xmin, ymin], [0.2, ymin], [0.2, ymax], [xmin, ymax]])
    field = replace(SQUARE, seen=(seen,))
    before, shown = field.floor.image.astype(float), shown_floor(field).astype(float)
    changed = shown != before
    border = (0.2 - xmin) / field.floor.resolution
    reach = (REACH + 2) * SIDE / field.floor.resolution
    assert not changed[:, : round(border)].any()
    beyond = changed[:, round(border + reach) :]
    assert 0.4 < beyond.mean() < 0.6
    hatched = before[changed]
    assert np.abs(shown[changed] - DARKER * hatched).max() <= 1
