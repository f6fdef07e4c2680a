"""Recordings begin, end, and end by themselves, whatever the disk does; the robot never waits."""

import resource
import shutil
from contextlib import contextmanager

import pytest
from engine_runs import EIGHT, kinematic, run
from recordings import InStep, begin, record, recorder_of
from rosbags.highlevel import AnyReader

from app.features.recordings import recorder as recorder_module
from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.files.recording_file import RecordingFile
from app.features.ros.publisher import TopicPublisher
from app.settings.groups import RecordingSettings
from robot.settings import SettingError
from sim.simulated import PERIOD


@pytest.fixture(scope="module")
def program():
    return kinematic(seed=2)


@contextmanager
def disk_with(size):
    """No file may become larger than so many bytes meanwhile."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def ticks(program, publisher, seconds):
    for _ in range(round(seconds / PERIOD)):
        publisher.tick(run(program, PERIOD, EIGHT)[0])


def test_a_recording_has_the_date_as_its_name_and_is_finished(program, tmp_path):
    folder, shown, _ = record(program, tmp_path / "new" / "folder", 1.0, EIGHT)
    assert folder == tmp_path / "new" / "folder" / "brickpose_2026_11_21-22_16_28"
    reader = open_recording(folder)
    assert not reader.unfinished
    assert reader.duration == pytest.approx(shown[-1].stamp - shown[0].stamp)
    with AnyReader([folder]) as theirs:
        assert theirs.message_count == len(list(reader.messages()))


def test_the_status_tells_what_is_recorded(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path)
    assert recorder.status is None
    folder = begin(recorder, publisher)
    assert recorder.status.running
    assert recorder.status.file == folder.name
    ticks(program, publisher, 1.0)
    recorder.close()
    done = recorder.status
    assert (done.running, done.message) == (False, None)
    assert done.duration_s == pytest.approx(1.0 - PERIOD)
    assert done.size_bytes == next(folder.glob("*.mcap")).stat().st_size


def test_one_at_a_time_and_another_one_afterwards(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path)
    first = begin(recorder, publisher)
    with pytest.raises(RecordingError, match=f"{first.name} is being recorded; stop it first"):
        recorder.start()
    recorder.close()
    recorder.close()
    second = begin(recorder, publisher)
    recorder.close()
    assert second.name == f"{first.name}-2"
    assert not publisher._routes


def test_each_recording_has_what_never_changes(program, tmp_path):
    for count in range(2):
        folder, _, _ = record(program, tmp_path / str(count), 0.2)
        names = [m.topic for m in open_recording(folder).messages()]
        for topic in ("/map", "/tf_static", "/robot_description"):
            assert names.count(topic) == 1


def test_a_folder_that_can_be_none_is_refused(program, tmp_path):
    (tmp_path / "file").write_text("")
    recorder, _ = recorder_of(program, tmp_path / "file" / "below")
    with pytest.raises(RecordingError, match=r"nothing can be recorded to .*; valid is a folder"):
        recorder.start()
    assert recorder.status is None


def test_a_full_disk_ends_the_recording_with_a_message_and_nothing_else(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path)
    folder = begin(recorder, publisher)
    with disk_with(600_000):
        while recorder.status.running:
            ticks(program, publisher, 0.1)
    status = recorder.status
    assert status.message.startswith("The disk is full: the recording ended after")
    assert status.message == recorder.failure
    assert publisher.failures == ()
    assert not publisher._routes
    reader = open_recording(folder)
    assert reader.unfinished
    assert reader.duration > 0.3
    ticks(program, publisher, 0.1)  # the rest goes on
    assert begin(recorder, publisher)
    recorder.close()
    assert recorder.failure is None


def test_a_full_disk_is_a_problem_as_long_as_it_is_full(program, small_disk):
    recorder, publisher = recorder_of(program, small_disk)
    assert recorder.problem is None
    other = small_disk / "other"
    other.write_bytes(bytes(2_900_000))
    begin(recorder, publisher)
    for _ in range(200):
        if not recorder.status.running:
            break
        ticks(program, publisher, 0.1)
    recorder.close()
    for _ in range(3):
        assert recorder.problem.startswith("The disk is full")
    other.unlink()
    assert recorder.problem is None
    other.write_bytes(bytes(2_900_000))
    assert recorder.problem.startswith("The disk is full")


def test_a_recording_whose_folder_is_deleted_ends_and_says_so(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path)
    folder = begin(recorder, publisher)
    shutil.rmtree(folder)
    for _ in range(200):
        ticks(program, publisher, 0.1)
        if not recorder.status.running:
            break
    else:
        recorder.close()
    assert "its file was deleted" in recorder.failure
    assert "kept" not in recorder.failure
    assert not folder.exists()


def test_a_disk_that_is_full_from_the_start_is_told(program, tmp_path):
    recorder, _ = recorder_of(program, tmp_path)
    with disk_with(10):
        recorder.start()
        recorder._run.join()
    assert recorder.status.message.startswith("The disk is full")


def test_a_folder_that_goes_away_ends_the_recording_with_its_reason(program, tmp_path, monkeypatch):
    recorder, publisher = recorder_of(program, tmp_path)
    begin(recorder, publisher)

    def gone(file):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(RecordingFile, "flush", gone)
    while recorder.status.running:
        ticks(program, publisher, 0.1)
    assert "cannot be written (Input/output error)" in recorder.status.message


def test_what_finds_no_room_is_lost_counted_and_told(program, tmp_path, monkeypatch):
    monkeypatch.setattr(recorder_module, "MOST_WAITING", 50)
    monkeypatch.setattr(recorder_module, "PERIOD_S", 60.0)  # the disk does not answer
    recorder, publisher = recorder_of(program, tmp_path)
    folder = begin(recorder, publisher)
    ticks(program, publisher, 1.0)
    publisher.lost = 7  # the topics' thread found no room, either
    recorder.close()
    told = recorder.status.message
    lost = int(told.split()[0])
    assert lost > 50
    assert "and 7 ticks are missing" in told
    reader = open_recording(folder)
    assert len(list(reader.messages())) == 50
    assert reader.metadata["missing"]["messages"] == told


def test_a_message_that_cannot_be_made_costs_only_its_topic(program, tmp_path, monkeypatch):
    recorder, publisher = recorder_of(program, tmp_path)
    folder = begin(recorder, publisher)
    from app.features.ros.message_types import MessageError
    from app.features.ros.topics import Published

    whole = Published.cdr.func

    def cdr(published):
        if published.topic.name == "odom":
            raise MessageError("no nav_msgs/msg/Odometry: nan")
        return whole(published)

    monkeypatch.setattr(Published, "cdr", property(cdr))
    ticks(program, publisher, 0.5)
    recorder.close()
    assert recorder.status.message.startswith("odom is not recorded: no nav_msgs")
    topics = {m.topic for m in open_recording(folder).messages()}
    assert "/odom" not in topics
    assert "/tf" in topics


def test_the_clock_is_held_while_it_records(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path)
    clock = publisher.source.clock
    for count in (1, 2):
        begin(recorder, publisher)
        assert clock._holders == 1, count
        recorder.close()
        assert clock._holders == 0, count


def test_all_pictures_are_recorded_at_rate_zero(program, tmp_path):
    folder, shown, _ = record(program, tmp_path, 0.5, EIGHT, picture_rate=0.0)
    pictures = list(open_recording(folder).messages({"/camera/image/compressed"}))
    assert len(pictures) == sum(one.reading.frame is not None for one in shown)
    with pytest.raises(SettingError, match="picture_rate"):
        RecordingSettings(picture_rate=-1.0)


def test_with_threads_the_recording_follows_the_engine(program, tmp_path):
    recorder, publisher = recorder_of(program, tmp_path, publisher=TopicPublisher)
    folder = begin(recorder, publisher)
    while recorder.status.duration_s < 1.0:  # ticks of simulated time, much faster than real
        run(program, PERIOD, EIGHT)
    recorder.close()
    publisher.close()
    assert isinstance(publisher, TopicPublisher) and not isinstance(publisher, InStep)
    reader = open_recording(folder)
    assert {"/scan", "/joint_states", "/truth"} <= set(reader.topics)
    times = [m.log_time_ns for m in reader.messages({"/joint_states"})]
    assert times == sorted(set(times))
