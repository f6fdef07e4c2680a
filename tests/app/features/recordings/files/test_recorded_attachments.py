"""Files within a foreign recording, whose names may be anything."""

import pytest
from recordings import FACTS, write_ticks

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.recording_file import RecordingFile
from app.features.recordings.replay.parts import RecordedParts


@pytest.mark.parametrize("name", ["map/a\0b", f"map/{'x' * 256}", "robot/..", "/robot/a", "map"])
def test_a_name_that_no_file_can_have_is_passed_over(tmp_path, name):
    file = RecordingFile(tmp_path / "drive", FACTS)
    file.attach(name, b"foreign", "text/plain")
    write_ticks(file, 2)
    file.close()
    parts = RecordedParts.of(open_recording(file.path))
    assert (parts.field, parts.damaged) == (None, ())


@pytest.mark.parametrize("where", ["{secret}", "../../{secret}"])
def test_a_foreign_map_does_not_show_pictures_of_this_computer(tmp_path, where):
    secret = tmp_path / "secret.pgm"
    secret.write_bytes(b"P5 4 4 255\n" + bytes(8) + b"\xff" * 8)
    image = where.format(secret=secret)
    settings = "resolution: 0.1\norigin: [0, 0, 0]\noccupied_thresh: 0.6\nfree_thresh: 0.2\n"
    for name, picture in (("inside", "secret.pgm"), ("outside", image)):
        file = RecordingFile(tmp_path / name, {**FACTS, "map_file": "map/a.yaml"})
        text = f"image: {picture}\nnegate: 0\n{settings}"
        file.attach("map/a.yaml", text.encode(), "application/yaml")
        file.attach("map/secret.pgm", secret.read_bytes(), "image/x-portable-graymap")
        write_ticks(file, 2)
        file.close()
    assert RecordedParts.of(open_recording(tmp_path / "inside")).field is not None
    with pytest.raises(RecordingError, match="valid is one beside"):
        RecordedParts.of(open_recording(tmp_path / "outside"))
