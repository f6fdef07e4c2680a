"""The pictures by which a scanner's constant is judged."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import constant_scans


def test_the_same_pictures_are_scanned_again_and_others_on_request(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(constant_scans, "PICTURES", 4)
    kept = tmp_path / "pictures"
    first = constant_scans.tried(constant_scans.recorded(kept), 0)
    again = constant_scans.tried(constant_scans.recorded(kept), 0)
    other = constant_scans.tried(constant_scans.recorded(kept), 1000)
    assert first == again
    assert len(first["each"]) == len(other["each"]) == 3 * 2 * 4
    assert first["each"] != other["each"]
    assert first["straight: sd [mm]"] < 1 and first["straight: false [%]"] == 0
