"""The pace of a replay: pause, seek, steps and speed, as the engine's thread runs it."""

import threading
from contextlib import contextmanager

import pytest
from replays import course_of, gist, recorded_eight, to_the_end

from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.messages.commands import ScatterCommand, SetParametersCommand

pytestmark = pytest.mark.slow

SOON_S = 60.0
"""The machine may be busy; nothing is waited for that long."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return recorded_eight(tmp_path_factory.mktemp("recordings"), seconds=6)[0]


@pytest.fixture(scope="module")
def straight(recording):
    return {one.stamp: gist(one) for one in to_the_end(course_of(recording))}


class Watched:
    """A replay that runs, and everything that it shows."""

    def __init__(self, program, replay, feed):
        self.program, self.replay, self._feed = program, replay, feed

    def until(self, condition):
        """The first snapshot from here on that meets a condition."""
        while True:
            shown = self._feed.get(SOON_S)
            assert shown is not None, "nothing is shown any more"
            if condition(shown):
                return shown

    def told(self, command):
        self.program.engine.commands.put(command)


@contextmanager
def running(path, **options):
    program = open_replay(path, ReplayOptions(**options))
    replay = program.replay
    stop = threading.Event()
    thread = threading.Thread(target=replay.run, args=(stop,))
    with program.engine.every.subscribe(100_000) as feed:
        thread.start()
        try:
            yield Watched(program, replay, feed)
        finally:
            stop.set()
            thread.join(SOON_S)
            assert not thread.is_alive()
    assert program.engine.failure is None


def stands(shown):
    return shown.replay.paused and shown.replay.catching_up is None


def at(seconds):
    return lambda shown: stands(shown) and abs(shown.replay.position_s - seconds) < 0.021


def test_it_plays_to_the_end_and_stands_there(recording, straight):
    with running(recording, speed=20) as watched:
        first = watched.until(lambda shown: True)
        assert (first.replay.position_s, first.replay.paused) == (0.0, False)
        last = watched.until(stands)
        assert last.replay.position_s == pytest.approx(last.replay.duration_s)
        assert gist(last) == straight[last.stamp]
        # Still there, and told again and again.
        again = watched.until(stands)
        assert again.published > last.published
        # To play from the end is to play from the beginning.
        watched.replay.asked.ask(paused=False)
        watched.until(lambda shown: shown.replay.position_s < 1 and not shown.replay.paused)


def test_it_goes_where_it_is_asked_and_says_there_what_a_straight_run_says(recording, straight):
    with running(recording, paused=True) as watched:
        for seconds in (4.5, 1.25, 5.5, 0.0, 3.0):
            watched.replay.asked.ask(position_s=seconds)
            shown = watched.until(at(seconds))
            assert gist(shown) == straight[shown.stamp]


def test_of_many_places_asked_for_the_last_counts(recording, straight):
    with running(recording, paused=True) as watched:
        for seconds in (5.0, 1.0, 4.0, 2.0):
            watched.replay.asked.ask(position_s=seconds)
        shown = watched.until(at(2.0))
        assert gist(shown) == straight[shown.stamp]


def test_steps_go_from_picture_to_picture_and_pause(recording, straight):
    with running(recording, speed=1) as watched:
        watched.replay.asked.ask(position_s=3.0, paused=True)
        here = watched.until(at(3.0))
        watched.replay.asked.ask(step=2)
        on = watched.until(lambda shown: stands(shown) and shown.stamp > here.stamp)
        assert on.frame.stamp > here.frame.stamp
        assert on.reading.frame is on.frame, "it stands at the tick of a picture"
        watched.replay.asked.ask(step=-2)
        back = watched.until(lambda shown: stands(shown) and shown.stamp < on.stamp)
        assert back.frame.stamp == pytest.approx(here.frame.stamp)
        assert gist(back) == straight[back.stamp]


def test_each_of_many_steps_counts_also_while_it_is_on_its_way(recording):
    pictures = [one.stamp for one in to_the_end(course_of(recording)) if one.reading.frame]
    with running(recording, paused=True) as watched:
        watched.replay.asked.ask(position_s=3.0)
        for _ in range(5):
            watched.replay.asked.ask(step=1)
        shown_last = [stamp for stamp in pictures if stamp <= 3.0][-1]
        expected = pictures[pictures.index(shown_last) + 5]
        watched.until(lambda shown: stands(shown) and shown.stamp == expected)


def test_parameters_that_are_set_during_a_step_hold(recording):
    few = SetParametersCommand(type="set_parameters", values={"max_particles": 200})
    with running(recording, paused=True) as watched:
        watched.until(stands)
        watched.replay.asked.ask(step=20)
        watched.told(few)
        watched.until(lambda s: stands(s) and s.filter.parameters.filter.max_particles == 200)


def test_on_the_way_it_shows_what_was_recorded_there(recording):
    with running(recording, paused=True) as watched:
        watched.replay.asked.ask(position_s=5.5)
        way = watched.until(lambda shown: shown.replay.catching_up is not None)
        assert 0 <= way.replay.catching_up <= 1
        assert way.replay.position_s == 5.5
        assert way.stamp == pytest.approx(5.5, abs=0.03)
        assert way.replay.estimate_then.distance_to(way.truth) < 0.02
        assert way.estimate is None
        there = watched.until(at(5.5))
        assert there.frame.stamp == pytest.approx(way.frame.stamp, abs=0.07)


def test_parameters_are_taken_while_it_stands_and_on_the_way(recording):
    few = SetParametersCommand(type="set_parameters", values={"max_particles": 200})
    fewer = SetParametersCommand(type="set_parameters", values={"max_particles": 150})
    with running(recording, paused=True) as watched:
        watched.told(few)
        shown = watched.until(lambda shown: shown.filter.parameters.filter.max_particles == 200)
        assert stands(shown)
        watched.replay.asked.ask(position_s=5.5)
        watched.until(lambda shown: shown.replay.catching_up is not None)
        watched.told(fewer)
        there = watched.until(at(5.5))
        assert there.filter.parameters.filter.max_particles == 150
        anew = course_of(recording)
        for one in (few, fewer):
            anew.change(one)
        anew.go_near(anew.robot.start_ns + 5_500_000_000)
        *_, expected = anew.ticks_up_to(anew.robot.start_ns + 5_500_000_000)
        assert gist(there) == gist(expected)


def test_a_scatter_acts_while_it_stands_and_is_gone_with_a_seek(recording, straight):
    with running(recording, paused=True) as watched:
        watched.replay.asked.ask(position_s=4.0)
        here = watched.until(at(4.0))
        watched.told(ScatterCommand(type="scatter"))
        watched.until(lambda shown: shown.estimate is None and stands(shown))
        watched.replay.asked.ask(position_s=4.0)
        again = watched.until(lambda shown: at(4.0)(shown) and shown.estimate is not None)
        assert gist(again) == gist(here) == straight[here.stamp]


def test_a_speed_may_change_while_it_plays(recording):
    with running(recording, speed=0.5) as watched:
        watched.until(lambda shown: shown.replay.speed == 0.5)
        watched.replay.asked.ask(speed=1e9)
        watched.until(lambda shown: shown.replay.speed == 50.0)
        watched.until(stands)
