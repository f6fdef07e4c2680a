"""The size of a picture is known before its pixels are made."""

import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.recordings.replay.decoding import JPEG, PNG, ContentError, picture_of, size_of
from app.features.ros.encoding.frames import time
from app.features.ros.message_types import new, to_cdr

TYPE = "sensor_msgs/msg/CompressedImage"


@given(
    st.integers(1, 300),
    st.integers(1, 300),
    st.sampled_from([(), (3,)]),
    st.sampled_from([(".png",), (".jpg",), (".jpg", [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])]),
)
def test_it_is_that_of_the_decoded_picture(height, width, colours, coding):
    data = cv2.imencode(coding[0], np.zeros((height, width, *colours), np.uint8), *coding[1:])[1]
    assert size_of(data.tobytes()) == (height, width)


@given(st.sampled_from([b"", JPEG, PNG]), st.binary(max_size=60))
def test_any_bytes_have_a_size_or_none(begin, rest):
    found = size_of(begin + rest)
    assert found is None or len(found) == 2


def chunk(kind, data):
    body = kind + data
    return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))


def test_a_picture_that_would_fill_the_memory_is_refused_before_it_is_decoded(monkeypatch):
    side = 30_000
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    bomb = PNG + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000)))
    monkeypatch.setattr(cv2, "imdecode", None)
    header = new("std_msgs/msg/Header", stamp=time(0), frame_id="")
    message = new(TYPE, header=header, format="jpeg", data=np.frombuffer(bomb, np.uint8))
    with pytest.raises(ContentError, match="a picture has 30000 x 30000 pixels"):
        picture_of(to_cdr(message, TYPE), (480, 640))
