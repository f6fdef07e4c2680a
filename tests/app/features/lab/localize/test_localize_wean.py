"""A real robot in a real building: the Wean Hall log, which is not part of this repository."""

import pytest

from benchmarks.lasers import wean

pytestmark = [
    pytest.mark.data,
    pytest.mark.skipif(not wean.DATA.is_dir(), reason="needs the Wean Hall log"),
    pytest.mark.slow,
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


@pytest.mark.parametrize(("begin", "seed"), [(0.0, 48), (20.0, 100), (60.0, 100)])
def test_a_corridor_that_looks_alike_is_not_told(tmp_path, begin, seed):
    """Each told a wrong place for 20 to 100 s when one cloud had to keep all of them."""
    wean.write_map(tmp_path / "wean.yaml")
    wean.write_bag(tmp_path / "bag", begin=begin)
    found, stamps, poses = wean.localized(tmp_path, seed)
    told, wrong, longest = wean.wrong_poses(stamps, poses)
    assert wrong <= 0.01 * told
    assert longest <= 10
    assert found["scans"]["withdrawn"] <= 0.05 * found["scans"]["used"]
    if begin < 60:
        assert told
