"""Recordings made by hand, and of programs that are stepped without a clock."""

from datetime import datetime

import yaml
from engine_runs import run

from app.features.recordings.contents import contents_of
from app.features.recordings.files.recording_file import METADATA_FILE, RecordingFile
from app.features.recordings.recorder import MOST_WAITING, Recorder
from app.features.ros.message_types import new, to_cdr
from app.features.ros.publisher import TopicPublisher
from app.features.ros.source import TopicSource
from app.features.ros.topics import LATCHED, TOPICS, Quality
from app.settings.groups import RecordingSettings
from sim.simulated import PERIOD

BEGIN_NS = 1_800_000_000_000_000_000
TICK_NS = 20_000_000
TEXT = "std_msgs/msg/String"
FACTS = {"robot": "Kinematic robot", "map": "square", "seed": "7", "version": "0.1.0"}


def text_cdr(text):
    return to_cdr(new(TEXT, data=text), TEXT)


def write_ticks(file, count, first=0):
    """A text each tick, and now and then a latched one."""
    for tick in range(first, first + count):
        now = BEGIN_NS + tick * TICK_NS
        if tick % 100 == 0:
            file.write("/robot_description", TEXT, LATCHED, now, now, text_cdr(f"robot {tick}"))
        file.write("/command", TEXT, Quality(), now, now, text_cdr(f"tick {tick}"))


def make(folder, ticks=200, close=True):
    """A recording with one attachment; its file and the last message's tick."""
    file = RecordingFile(folder, FACTS)
    file.attach("settings.toml", b"seed = 7\n", "application/toml", BEGIN_NS)
    write_ticks(file, ticks)
    if close:
        file.close()
    else:
        file.abandon()
    return file.path


class InStep(TopicPublisher):
    """Publishes each tick when it is told, in the caller's thread: nothing is ever late."""

    def add(self, route):
        self._routes = (*self._routes, route)

    def remove(self, route):
        self._routes = tuple(one for one in self._routes if one is not route)

    def tick(self, snapshot):
        self.source.clock.follow(snapshot)
        for topic in TOPICS:
            self.publish(topic, snapshot)
        assert self.failures == ()


def recorder_of(program, folder, publisher=InStep, **settings):
    """A recorder of a program, with its publisher."""
    publisher = publisher(TopicSource.of(program), program.engine.every)
    recorder = Recorder(
        publisher,
        RecordingSettings(folder=str(folder), **settings),
        lambda: contents_of(program),
        lambda: datetime(2026, 11, 21, 22, 16, 28),
    )
    return recorder, publisher


def begin(recorder, publisher):
    """Start a recording, and wait until it takes messages."""
    folder = recorder.start()
    while not publisher._routes and recorder.status.running:
        recorder._run._thread.stopping.wait(0.001)
    return folder


def record(program, folder, seconds, *renewed, **settings):
    """Drive and record; the recording's folder and the snapshots that it was made of."""
    recorder, publisher = recorder_of(program, folder, **settings)
    made = begin(recorder, publisher)
    shown = []
    for _ in range(round(seconds / PERIOD)):
        shown += run(program, PERIOD, *renewed)
        publisher.tick(shown[-1])
        # The drive is faster than real time; a busy computer's writer comes along later.
        while len(recorder._run._waiting) > MOST_WAITING // 2 and recorder.status.running:
            recorder._run._thread.stopping.wait(0.001)
    recorder.close()
    assert recorder.failure is None
    assert recorder.status.message is None
    return made, shown, publisher.source


def metadata_of(folder):
    """What a recording's metadata.yaml tells."""
    return yaml.safe_load((folder / METADATA_FILE).read_text(encoding="utf-8"))[
        "rosbag2_bagfile_information"
    ]
