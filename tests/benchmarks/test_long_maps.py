"""The benchmark of maps of long drives."""

import pytest

from benchmarks import long_maps


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_a_short_drive_has_a_map_and_its_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(long_maps, "DRIVES", long_maps.DRIVES[:1])
    monkeypatch.setattr(long_maps, "LAPS", (1,))
    monkeypatch.setattr(long_maps, "LONGEST_S", 50.0)
    result = long_maps.measure()
    assert result.brickpose > result.more["square, default, 1 laps [s]"] > 0
    assert result.more["square, default, 30 min edges off, mean [mm]"] < 0.5
    assert result.more["square, default, 30 min not drawn [%]"] < 5
