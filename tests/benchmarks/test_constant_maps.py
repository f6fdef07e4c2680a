"""The drives by which a constant of mapping is judged."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import pytest

from benchmarks import constant_maps
from robot.mapping.tape_map import MappingError


def refused(*drive: object) -> NoReturn:
    raise MappingError("it saw no tape")


@pytest.mark.slow
def test_maps_are_judged_by_the_truth_and_a_refused_one_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constant_maps, "DRAWN", constant_maps.DRAWN[:1])
    kept = tmp_path / "drives"
    usual = constant_maps.tried(constant_maps.recorded(kept), 0)
    assert usual["map's edges off [mm]"] < 1 and usual["not drawn [%]"] < 5
    assert usual["refused"] == 0
    monkeypatch.setattr(constant_maps, "draw_map", refused)
    assert constant_maps.tried(constant_maps.recorded(kept), 0)["refused"] == 1
