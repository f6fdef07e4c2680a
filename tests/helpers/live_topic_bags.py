"""Recordings of live topics, as ``ros2 bag record`` makes them of our robot."""

import cv2
import numpy as np
from recordings import BEGIN_NS

from app.features.recordings.files.mcap_reader import open_recording
from app.features.recordings.files.recording_file import RecordingFile
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.features.recordings.replay.ticks import RecordedTopics
from app.features.ros.message_types import new, to_cdr
from app.features.ros.topics import Quality
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive

JOINTS = "sensor_msgs/msg/JointState"
PICTURE = "sensor_msgs/msg/CompressedImage"
SPEC = RobotSpec.load()
GREY = np.full((SPEC.lens.height, SPEC.lens.width), 200, np.uint8)
GREY_JPEG = cv2.imencode(".jpg", GREY)[1].ravel()


def header(seconds):
    ns = BEGIN_NS + round(seconds * 1e9)
    stamp = new("builtin_interfaces/msg/Time", sec=ns // 10**9, nanosec=ns % 10**9)
    return new("std_msgs/msg/Header", stamp=stamp, frame_id="")


class Bag:
    """A file as ``ros2 bag record`` makes it: only live topics, and nothing attached."""

    def __init__(self, folder, namespace=""):
        self.file = RecordingFile(folder)
        self.folder = folder
        self.namespace = namespace

    def write(self, topic, kind, seconds, message):
        ns = BEGIN_NS + round(seconds * 1e9)
        name = f"{self.namespace}/{topic}"
        self.file.write(name, kind, Quality(), ns, ns, to_cdr(message, kind))

    def joints(self, seconds, turned=0.0, logged=None, names=None, speed=0.0):
        names = [joint.name for joint in SPEC.joints] if names is None else names
        message = new(
            JOINTS,
            header=header(seconds),
            name=names,
            position=np.full(len(names), turned),
            velocity=np.full(len(names), speed),
            effort=np.empty(0),
        )
        self.write("joint_states", JOINTS, seconds if logged is None else logged, message)

    def picture(self, seconds, logged=None, data=GREY_JPEG):
        message = new(PICTURE, header=header(seconds), format="jpeg", data=np.asarray(data))
        logged = seconds if logged is None else logged
        self.write("camera/image/compressed", PICTURE, logged, message)

    def text(self, topic, seconds, text):
        kind = "std_msgs/msg/String"
        self.write(topic, kind, seconds, new(kind, data=text))

    def robot(self):
        self.file.close()
        reader = open_recording(self.folder)
        drive = DifferentialDrive(SPEC)
        return RecordedRobot(reader, RecordedTopics.of(reader.topics), SPEC, drive, "Recording")
