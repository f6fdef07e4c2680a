"""Replays of a recording that the simulator makes in no time."""

from engine_runs import EIGHT, kinematic
from recordings import record

from app.features.recordings.replay.opening import ReplayOptions, open_replay

SECONDS = 10


def recorded_eight(folder, seconds=SECONDS, **settings):
    """The figure-eight; the recording's folder and the snapshots that it was made of."""
    made, shown, _ = record(kinematic(seed=1), folder, seconds, EIGHT, **settings)
    return made, shown


def course_of(path, **options):
    """A replay that nobody paces."""
    return open_replay(path, ReplayOptions(**options)).replay.timeline


def to_the_end(timeline):
    return list(timeline.ticks_up_to(2**62))


def gist(snapshot):
    """What must be the same, bit for bit."""
    cloud = snapshot.filter.cloud
    return snapshot.stamp, snapshot.pose, cloud.poses.tobytes(), cloud.weights.tobytes()


def go(timeline, seconds):
    """Go to a time as the page does; what is shown there."""
    log_ns = timeline.robot.start_ns + round(seconds * 1e9)
    timeline.go_near(log_ns)
    *_, shown = (None, *timeline.ticks_up_to(log_ns))
    return shown or timeline.apply_between_ticks(())
