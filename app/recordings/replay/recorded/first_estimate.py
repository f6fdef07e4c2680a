"""Finds the estimate at the beginning of a recording."""

from __future__ import annotations

import numpy as np

from app.recordings.files.mcap_reader import RecordingReader
from app.recordings.files.recorded import RecordingError
from app.recordings.replay.recorded.decoding import ContentError, pose_and_covariance_of
from app.recordings.replay.recorded.topics import RecordedTopics
from app.ros2.message_types import MessageError
from robot.localization.estimate import Hypothesis

SOON_NS = 10_000_000_000
"""An estimate later than this after the first tick says nothing about the beginning [ns]."""

SINCE = np.diag(np.square([0.01, 0.01, 0.03]))
"""Covariance of the robot's possible motion since the estimate [m², m², rad²]."""


def first_estimate(
    reader: RecordingReader, topics: RecordedTopics, start_ns: int
) -> Hypothesis | None:
    """Return the first usable estimate of the first ten seconds; None if there is none.

    Args:
        reader: the recording.
        topics: its topics.
        start_ns: time of the first tick.
    """
    if not topics.amcl_pose:
        return None
    try:
        for message in reader.messages((topics.amcl_pose,)):
            if message.log_time_ns > start_ns + SOON_NS:
                return None
            _, pose, covariance = pose_and_covariance_of(message.cdr)
            spread = covariance + SINCE
            if np.linalg.eigvalsh(spread)[0] <= 0:
                continue
            return Hypothesis(1.0, pose, spread)
    except (RecordingError, MessageError, ContentError):
        return None
    return None
