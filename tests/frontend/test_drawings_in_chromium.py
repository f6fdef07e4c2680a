"""Floors of drawings are what Chromium shows of the same file."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from drawing_habits import DRAWINGS

from robot.fields.svg_field import field_of_drawing

pytestmark = pytest.mark.slow

WIDTH, HEIGHT = 420, 300
"""Of each drawing [mm]; a pixel of its floor is a millimetre."""
FINER = 3
"""Chromium's pixels in one of ours, along each side: its borders are coarser than ours."""
NOTICED = 48
"""Grey levels: smaller differences are those of two ways to draw a slanted border."""
MOST = 0.001
"""Share of a drawing's pixels that may differ."""


@pytest.fixture(scope="module")
def pictures(chromium, tmp_path_factory):
    """Chromium's pictures of drawings, as grey levels."""
    pixels_per_mm = 96 / 25.4
    page = chromium([]).new_page(
        viewport={"width": round(WIDTH * pixels_per_mm), "height": round(HEIGHT * pixels_per_mm)},
        device_scale_factor=FINER / pixels_per_mm,
    )
    file = tmp_path_factory.mktemp("drawings") / "drawing.svg"

    def picture(text):
        file.write_text(text, encoding="utf-8")
        page.goto(file.as_uri())
        fine = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_GRAYSCALE)
        whole = fine[: FINER * HEIGHT, : FINER * WIDTH]
        return cv2.resize(whole, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)

    yield picture
    page.close()


@pytest.mark.browser
@pytest.mark.parametrize("name", DRAWINGS)
def test_a_floor_is_what_chromium_shows(pictures, name):
    floor = field_of_drawing(DRAWINGS[name], "drawing").floor.image
    height, width = floor.shape  # sizes that are rounded lose a pixel
    assert WIDTH - width <= 1 and HEIGHT - height <= 1
    shown = pictures(DRAWINGS[name])[:height, :width]
    assert shown.std() > 10, "Chromium shows nothing"
    differ = np.abs(floor.astype(np.int16) - shown) > NOTICED
    assert differ.mean() <= MOST


def test_there_are_sixty_drawings():
    assert len(DRAWINGS) >= 60
