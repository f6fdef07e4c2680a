"""A folder of pictures, or a video, as a camera: for tests and teaching without a robot.

Pictures are due at the pace of a camera, by the clock. After the last one they start again from the
first. Pictures that nobody fetched in time are skipped.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import cv2

from robot.camera import Lens
from robot.cameras.camera import Picture, PictureError, SourceError, check_size, upright
from robot.cameras.picture_files import (
    AS_TAKEN,
    SUFFIXES,
    pictures_in,
    read_picture,
    turned_line,
)
from robot.interface import Frame

_log = logging.getLogger(__name__)

LONGEST_LAG_S = 1.0
"""If no picture was fetched for longer, the pace restarts instead of catching up [s]."""


class Pictures(Protocol):
    """An endless sequence of pictures."""

    name: str

    def next(self, skip: int) -> Picture:
        """Skip some pictures, then return one.

        Raises:
            PictureError: the picture cannot be read.
        """
        ...

    def close(self) -> None:
        """Release the file."""
        ...


class FileCamera:
    """A camera whose pictures are read from files when they are due."""

    def __init__(
        self,
        pictures: Pictures,
        lens: Lens,
        frame_rate: float,
        rotation: int,
        clock: Callable[[], float],
    ) -> None:
        """``frame_rate`` [1/s], ``rotation`` 0 or 180 [deg]; the first picture is due at once."""
        self.name = pictures.name
        self.problem: str | None = None
        self._pictures = pictures
        self._lens = lens
        self._period = 1 / frame_rate
        self._rotation = rotation
        self._clock = clock
        self._start = clock()
        self._handed_out = 0
        self._closed = False

    def newest(self) -> Frame | None:
        """Return the picture that is due, unless handed out before; its stamp is its due time."""
        since = self._clock() - self._start
        # The margin of 1e-6: a picture that is due exactly now counts as due despite rounding.
        due = math.floor(since / self._period + 1e-6) + 1
        if self._closed or due <= self._handed_out:
            return None
        skip = due - 1 - self._handed_out
        if skip * self._period > LONGEST_LAG_S:
            self._start, self._handed_out, due, skip = self._clock(), 0, 1, 0
        self._handed_out = due
        return self._frame(self._start + (due - 1) * self._period, skip)

    def _frame(self, stamp: float, skip: int) -> Frame | None:
        try:
            picture = upright(self._pictures.next(skip), self._rotation)
            check_size(picture.shape, self._lens, self.name)
        except PictureError as error:
            self.problem = str(error)
            return None
        self.problem = None
        return Frame(stamp, picture)

    def close(self) -> None:
        """Hand out no more pictures; may be called twice."""
        self._closed = True
        self.problem = f"{self.name} is closed"
        self._pictures.close()


class FolderPictures:
    """The pictures of a folder in the order of their names."""

    def __init__(self, folder: Path) -> None:
        """List the folder.

        Raises:
            SourceError: there are no pictures in it; the message names the valid endings.
        """
        self.name = f"the pictures in {folder}"
        self._paths = pictures_in(folder)
        self._next = 0
        self._told = False
        if not self._paths:
            raise SourceError(
                f"{folder} has no pictures; valid are files that end in {', '.join(SUFFIXES)}"
            )

    def next(self, skip: int) -> Picture:
        """Skip some pictures, then read one."""
        path = self._paths[(self._next + skip) % len(self._paths)]
        self._next = (self._next + skip + 1) % len(self._paths)
        picture = read_picture(path)
        if picture.asks_to_be_turned and not self._told:
            self._told = True
            _log.warning("%s", turned_line([str(path)]))
        return picture.pixels

    def close(self) -> None:
        """Do nothing: no file is open between two pictures."""


class VideoPictures:
    """The pictures of a video file."""

    def __init__(self, path: Path) -> None:
        """Open it.

        Raises:
            SourceError: the file is not a readable video.
        """
        self.name = f"the video {path}"
        self._path = path
        self._capture = cv2.VideoCapture()
        if not self._grab():
            self._capture.release()
            raise SourceError(
                f"{path} is no video that can be read; valid are a folder of pictures or "
                "a file such as .mp4, .avi or .mkv"
            )
        self._grabbed = True
        if self._capture.get(cv2.CAP_PROP_ORIENTATION_META):
            _log.warning("%s says that it is to be turned; %s", path, AS_TAKEN)

    @property
    def frame_rate(self) -> float | None:
        """Pictures per second [1/s]; None if the file does not tell, or tells an unlikely rate."""
        rate = self._capture.get(cv2.CAP_PROP_FPS)
        return rate if math.isfinite(rate) and 1 <= rate <= 240 else None

    def next(self, skip: int) -> Picture:
        """Skip some pictures, then decode one."""
        for _ in range(skip + 1 - self._grabbed):
            if not self._grab():
                raise PictureError(f"{self._path} cannot be read any more; was it changed?")
        self._grabbed = False
        done, picture = self._capture.retrieve()
        if not done:
            raise PictureError(f"{self._path} has a picture that cannot be decoded")
        return upright(picture, 0)

    def close(self) -> None:
        """Close the file."""
        self._capture.release()

    def _grab(self) -> bool:
        """Advance by one picture, from the last to the first; return whether that worked."""
        if self._capture.grab():
            return True
        self._capture.release()
        opened = self._capture.open(str(self._path), cv2.CAP_FFMPEG)
        # Phones write into a video, too, by how much it is to be turned when it is shown.
        self._capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        return opened and self._capture.grab()
