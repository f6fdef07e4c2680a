"""Which constants are tried together is checked before anything is tried."""

from __future__ import annotations

from benchmarks.constants import main


def test_constants_that_are_tried_on_pictures_and_on_drives_do_not_go_together(capsys) -> None:
    assert main(["track.SHARP+tape_edges.GAP"]) == 2
    assert "track.SHARP+tape_edges.GAP are tried in different ways" in capsys.readouterr().err
