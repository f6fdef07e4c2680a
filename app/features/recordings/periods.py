"""The period at which a topic is recorded, by the settings."""

from __future__ import annotations

from app.features.ros.topics import Topic
from app.settings.groups import RecordingSettings

EVERY_TICK = frozenset({"joint_states", "cmd_vel"})
"""Topics that are recorded at every tick: the robot's answers and commands. A replay needs all."""


def recorded_every(topic: Topic, settings: RecordingSettings) -> float:
    """Return the least time between two messages of a topic [s]; 0: record every message."""
    if topic.rate is None or topic.name in EVERY_TICK:
        return 0.0
    frequency = float(getattr(settings, topic.rate))
    return 1.0 / frequency if frequency else 0.0
