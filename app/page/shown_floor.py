"""The floor as people see it: hatched where nobody has looked."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.field import Field

STRIPE_M = 0.03
"""Width of the hatching's stripes, and of the gaps between them, along the axes [m]."""
DARKER = 0.82


def shown_floor(field: Field) -> NDArray[np.uint8]:
    """Return grey levels (h, w) of a field's floor, hatched where nobody has looked."""
    image, unseen = field.floor.image, field.unseen
    if not unseen.seen.size:
        return image
    height, width = image.shape
    scale = field.floor.resolution / unseen.side
    xmin, _, _, ymax = field.floor.extent
    # OpenCV's columns and rows are of pixels' middles.
    column = ((xmin - unseen.left) / field.floor.resolution + 0.5) * scale - 0.5
    row = ((ymax - unseen.bottom) / field.floor.resolution - 0.5) * scale - 0.5
    cells_from_pixels = np.array([[scale, 0, column], [0, -scale, row]])
    seen = cv2.warpAffine(
        unseen.seen,
        cells_from_pixels,
        (width, height),
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
    )
    stripe = STRIPE_M / field.floor.resolution
    along = np.arange(width)[None] + np.arange(height)[:, None]
    striped = (seen == 0) & ((along // stripe) % 2 == 0)
    return np.where(striped, DARKER * image, image).astype(np.uint8)
