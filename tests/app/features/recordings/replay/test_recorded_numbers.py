"""Numbers of recorded messages, which may be as large as a float can be."""

from app.features.recordings.replay.decoding import pose_and_covariance_of
from app.features.ros.message_types import to_cdr
from app.features.ros.rosbridge.reading import message_of

POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"


def test_a_covariance_of_huge_numbers_is_read_without_overflow():
    message = message_of({"pose": {"covariance": [1e308] * 36}}, POSE)
    _, _, covariance = pose_and_covariance_of(to_cdr(message, POSE))
    assert (covariance == 1e308).all()
