"""Files within a foreign recording, whose names may be anything."""

import pytest
from recordings import FACTS, write_ticks

from app.recordings.files.mcap_reader import open_recording
from app.recordings.files.recording_file import RecordingFile
from app.recordings.replay.parts import RecordedParts


@pytest.mark.parametrize("name", ["map/a\0b", f"map/{'x' * 256}", "robot/..", "/robot/a", "map"])
def test_a_name_that_no_file_can_have_is_passed_over(tmp_path, name):
    file = RecordingFile(tmp_path / "drive", FACTS)
    file.attach(name, b"foreign", "text/plain")
    write_ticks(file, 2)
    file.close()
    parts = RecordedParts.of(open_recording(file.path))
    assert (parts.field, parts.damaged) == (None, ())
