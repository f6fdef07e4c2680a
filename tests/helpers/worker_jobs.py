"""Jobs for workers, of which each leaves a line in a file when it begins."""

import os
import signal
from pathlib import Path


def double(job):
    """Twice the number."""
    folder, number = job
    _begin(folder, number)
    return 2 * number


def refuse_three(job):
    """Twice the number, unless that is three."""
    if job[1] == 3:
        raise ValueError("three is none of mine")
    return double(job)


def die_once_at_two(job):
    """Twice the number; the first worker that gets two is killed."""
    folder, number = job
    _begin(folder, number)
    if number == 2 and begun(folder).count(2) == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * number


def die_at_two(job):
    """Twice the number; whoever gets two is killed."""
    if job[1] == 2:
        _begin(*job)
        os.kill(os.getpid(), signal.SIGKILL)
    return double(job)


def process(job):
    """The worker's process."""
    return os.getpid()


def begun(folder):
    """Numbers of the jobs that were begun, in that order."""
    return [int(line) for line in (Path(folder) / "begun").read_text().split()]


def _begin(folder, number):
    with (Path(folder) / "begun").open("a") as file:
        file.write(f"{number}\n")


def megabytes(number):
    """So many of them, as a result that takes a while to send."""
    return bytes(number * 1_000_000)


class TwoWordsError(Exception):
    """An error that pickle cannot make again from its arguments."""

    def __init__(self, first, second):
        super().__init__(f"{first} {second}")


def fail_with_two_words(_):
    """Fail with an error that does not come through the pipe as it is."""
    raise TwoWordsError("not", "here")


def nothing_to_send(_):
    """A result that cannot be sent."""
    return lambda: None


def active_features(job):
    """The names of the features that take part where the job is done."""
    from app.engine.plugging import plugged

    return [feature.name for feature in plugged().features.active]
