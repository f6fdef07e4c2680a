"""The routes by which a constant of routes is judged."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import constant_routes


def test_places_are_reached(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constant_routes, "PLACES", 6)
    kept = tmp_path / "trial"
    usual = constant_routes.tried(constant_routes.recorded(kept), 0)
    assert usual == constant_routes.tried(constant_routes.recorded(kept), 0)
    assert usual["not reached"] == 0
    assert 0 < usual["place off [mm]"] < 40
    other = constant_routes.tried(constant_routes.recorded(kept), 1000)
    assert len(other["each"]) == len(usual["each"]) == 6 and other["each"] != usual["each"]
    # One that hardly moves does not come to its goal.
    monkeypatch.setattr("robot.driving.route.SPEED", 0.001)
    assert constant_routes.tried(constant_routes.recorded(kept), 0)["not reached"] > 0
