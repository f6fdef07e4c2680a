"""The routes and floors by which a constant of routes and of exploring is judged."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import constant_routes


def test_places_are_reached_and_floors_are_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constant_routes, "PLACES", 6)
    monkeypatch.setattr(constant_routes, "FLOORS", 1)
    kept = tmp_path / "trial"
    usual = constant_routes.tried(constant_routes.recorded(kept), 0)
    assert usual == constant_routes.tried(constant_routes.recorded(kept), 0)
    assert usual["not reached"] == usual["tape unseen [%]"] == 0
    assert 0 < usual["place off [mm]"] < 40 and usual["explored in [s]"] > 20
    other = constant_routes.tried(constant_routes.recorded(kept), 1000)
    assert len(other["each"]) == len(usual["each"]) == 6 + 1 and other["each"] != usual["each"]
    # One that hardly sees anything gives up, with tape that nobody saw.
    monkeypatch.setattr("robot.mapping.exploring.LEAST_GAIN", 1e6)
    assert constant_routes.tried(constant_routes.recorded(kept), 0)["tape unseen [%]"] > 10
