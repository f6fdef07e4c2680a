"""A real robot in a real building: the Wean Hall log, which is not part of this repository."""

import pytest

from benchmarks.lasers import wean

pytestmark = [
    pytest.mark.data,
    pytest.mark.skipif(not wean.DATA.is_dir(), reason="needs the Wean Hall log"),
]


def test_from_anywhere_in_the_building_the_robot_is_found(tmp_path):
    wean.write_map(tmp_path / "wean.yaml")
    wean.write_bag(tmp_path / "bag")
    found, stamps, poses = wean.localized(tmp_path, 0)
    distance, turn = wean.error_at_reference(stamps, poses)
    assert distance < wean.NEAR_M
    assert turn < wean.NEAR_RAD
    # And where it comes to stand, 0.36 m farther on.
    assert poses[-1] == pytest.approx([39.88, 41.42, 1.29], abs=0.1)
    assert found["known"]
