"""The simulated camera: the floor by projection, then lens, light and noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pkgutil import resolve_name

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.camera import FloorView
from robot.fields.field import FloorPicture
from robot.geometry import Pose2, Twist2
from robot.settings import check_settings, setting
from sim.floor_samples import FloorSamples

_NOISE_MARGIN = 64
"""How far the place in the table of noise is moved at random, by row and column [px]."""

KINDS = ("none", "discs", "cable", "shadow", "shoes", "all")
"""Kinds of things on the floor."""
TEXTURES = ("none", "wood", "lino", "carpet", "concrete")
"""Kinds of floor, which ``floor_textures`` makes."""
TONES = ("light", "dark")
"""Whether a kind is its light one or its dark one."""


@dataclass(frozen=True)
class CameraSettings:
    """How a real camera differs from a perfect one; defaults are of a Pi camera indoors."""

    frame_rate: float = setting(30.0, "Pictures a second", unit="1/s", low=1, high=120)
    exposure: float = setting(
        0.010, "Exposure time; what moves meanwhile is blurred", unit="s", low=0, high=0.1
    )
    delay: float = setting(
        0.005,
        "Time from the last row's exposure until the picture is in memory",
        unit="s",
        low=0,
        high=1,
    )
    blur: float = setting(0.7, "Standard deviation of the lens blur", unit="px", low=0, high=10)
    noise: float = setting(
        3.0, "Standard deviation of the sensor noise, of 255 grey levels", low=0, high=64
    )
    vignetting: float = setting(
        0.25, "Share of the light that is lost in the corners", low=0, high=0.9
    )
    stamp_error: float = setting(
        0.0, "How much later a picture is stamped than it was exposed", unit="s", low=0, high=1
    )
    light: float = setting(
        1.0, "Share of the light that there is; noise stays as it is", low=0.01, high=1
    )
    uneven_light: float = setting(
        0.0, "Share of the light that is lost where the floor is farthest from the lamp",
        low=0, high=0.95,
    )  # fmt: skip
    clutter: str = setting(
        "none", "Things on the floor that are no tape and in no map", choices=KINDS
    )
    texture: str = setting("none", "What the bare floor is made of", choices=TEXTURES)
    tone: str = setting("light", "Whether that is a light or a dark one", choices=TONES)
    glare: float = setting(
        0.0, "Grey levels that the reflections of lamps on the floor add at most", low=0, high=255
    )
    floor_scale: float = setting(
        1.0,
        "How much larger the taped floor is than its drawing",
        low=0.8,
        high=1.25,
    )
    lost_share: float = setting(
        0.0, "Share of the pictures that never arrive, in bursts", low=0, high=0.99
    )
    lost_burst: float = setting(
        0.0, "How long such a burst lasts on average; 0 is one picture", unit="s", low=0, high=60
    )
    gap: float = setting(
        0.0,
        "How long no picture arrives, once in each 15 s, at a moment drawn by chance",
        unit="s",
        low=0,
        high=14,
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def floor_as_drawn(self) -> bool:
        """Whether nothing lies or shines on the floor, and it is of one tone."""
        return self.clutter == self.texture == "none" and self.uneven_light == self.glare == 0


class FloorCamera:
    """Takes pictures of one floor through one lens."""

    def __init__(
        self,
        view: FloorView,
        floor: FloorPicture,
        settings: CameraSettings,
        rng: np.random.Generator,
    ) -> None:
        # Separate streams: noise is the same with and without clutter.
        streams = rng.spawn(3)
        if settings.floor_as_drawn:
            self._floor = floor.scaled(settings.floor_scale)
        else:  # by name: few floors are
            self._floor = resolve_name("sim.clutter:disturbed")(floor, settings, streams)
        self._settings = settings
        self._rng = rng
        self.turn(view)
        self._light = _light(view.lens.width, view.lens.height, settings.vignetting, settings.light)
        self._size = (view.lens.height, view.lens.width)
        table = view.lens.height + _NOISE_MARGIN, view.lens.width + _NOISE_MARGIN
        self._noise = np.rint(rng.normal(0, settings.noise, table)).astype(np.int16)

    def turn(self, view: FloorView) -> None:
        """Look at the floor in another way, through the same lens; no picture may be under way."""
        self._samples = FloorSamples(view, self._floor, self._settings.exposure)
        self._exposed: tuple[Pose2, Twist2, NDArray[np.uint8]] | None = None

    def picture(self, map_from_robot: Pose2, twist: Twist2) -> NDArray[np.uint8]:
        """Take a grey picture (h, w) at a pose in the map, while moving with a twist.

        The robot is at the pose in the middle of the exposure of the middle row.
        """
        return self.read_out(self.expose(map_from_robot, twist))

    def expose(self, map_from_robot: Pose2, twist: Twist2) -> NDArray[np.uint8]:
        """Return ``picture`` without the sensor's noise. Any thread may call this.

        It draws nothing by chance, so it may run ahead. Who stands gets the same read-only array.
        """
        last = self._exposed
        if last is None or last[:2] != (map_from_robot, twist):
            picture = self._through_the_lens(self._samples.average(map_from_robot, twist))
            picture.setflags(write=False)
            self._exposed = last = map_from_robot, twist, picture
        return last[2]

    def read_out(self, exposed: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Add the sensor's noise to an exposed picture (h, w)."""
        if self._settings.noise == 0:
            return exposed
        height, width = self._size
        # Noise is taken from a random position in a table: to draw it costs 5 ms a picture.
        row, column = self._rng.integers(0, _NOISE_MARGIN, 2)
        noise = self._noise[row : row + height, column : column + width]
        return np.asarray(cv2.add(exposed, noise, dtype=cv2.CV_8U), dtype=np.uint8)

    def _through_the_lens(self, ideal: NDArray[np.uint8]) -> NDArray[np.uint8]:
        picture: cv2.typing.MatLike = ideal
        if self._settings.blur > 0:
            picture = cv2.GaussianBlur(picture, (0, 0), self._settings.blur)
        picture = cv2.multiply(picture, self._light, dtype=cv2.CV_8U)
        return np.asarray(picture, dtype=np.uint8)


@lru_cache(maxsize=2)
def _light(width: int, height: int, lost: float, light: float) -> NDArray[np.float32]:
    """Share of the light left (h, w); the loss grows with the squared distance from the middle."""
    x = np.linspace(-1, 1, width)
    y = np.linspace(-1, 1, height)[:, None]
    return (1 - lost * (x * x + y * y) / 2).astype(np.float32) * np.float32(light)
