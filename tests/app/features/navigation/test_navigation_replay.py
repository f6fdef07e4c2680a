"""A journey is in its recording, and a replay shows it again, also after going back."""

from __future__ import annotations

import pytest
from engine_runs import kinematic, run
from journeys import KNOWN, RENEW, goal
from recordings import begin, recorder_of
from replays import go, to_the_end

from app.engine.commands import check
from app.features.navigation.messages import CancelCommand
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from robot.errors import CommandError
from sim.simulated import PERIOD

pytestmark = pytest.mark.slow

GOAL = goal(0.25, 0.1, 1.0)
LONGEST_S = 40.0


@pytest.fixture(scope="module")
def replayed(tmp_path_factory):
    """A recording of a journey that arrives, and one that is stopped; the replay; the states."""
    program = kinematic(seed=1)
    recorder, publisher = recorder_of(program, tmp_path_factory.mktemp("recordings"))
    folder = begin(recorder, publisher)
    states: list[tuple[float, str | None]] = []

    def step(*commands):
        shown = run(program, PERIOD, *commands)[-1]
        publisher.tick(shown)
        status = shown.added.get("navigation")
        states.append((shown.stamp, status and status.state))
        return states[-1][1]

    for _ in range(20):
        step(KNOWN)
    step(GOAL)
    for _ in range(round(LONGEST_S / PERIOD)):
        if step(RENEW) == "arrived":
            break
    # The replay plans at its own pace, and may be there some ticks later.
    for _ in range(100):
        step(RENEW)
    step(goal(-0.2, -0.1, 0.0))
    for _ in range(100):
        step(RENEW)
    step(CancelCommand(type="cancel"))
    for _ in range(20):
        step()
    recorder.close()
    program.engine._companions.close()
    return open_replay(folder, ReplayOptions()), states


def changes(states):
    told = [state for _, state in states]
    return [
        state for before, state in zip([None, *told[:-1]], told, strict=True) if state != before
    ]


def test_a_replay_shows_the_same_journeys(replayed):
    program, states = replayed
    shown = to_the_end(program.replay.timeline)
    again = [
        (each.stamp, each.added["navigation"].state if "navigation" in each.added else None)
        for each in shown
    ]
    assert changes(states)[-3:] == ["planning", "driving", "canceled"]
    assert changes(again)[-3:] == ["planning", "driving", "canceled"]
    assert "arrived" in changes(again)


def test_going_back_shows_the_journey_that_there_was(replayed):
    program, states = replayed
    timeline = program.replay.timeline
    to_the_end(timeline)
    began = next(stamp for stamp, state in states if state == "driving")
    begin_of_all = states[0][0]
    status = go(timeline, began - begin_of_all + 1.0).added["navigation"]
    assert status.state == "driving"
    assert (status.goals[0].x, status.goals[0].y) == (0.25, 0.1)
    assert status.path is not None
    # A journey can be stored: going back does not begin at the start.
    assert timeline.checkpoints.before(2**62).log_ns > timeline.robot.start_ns + 1e9 * (
        began - begin_of_all + 1.0
    )


def test_a_replay_takes_no_goals_of_its_own(replayed):
    program, _ = replayed
    with pytest.raises(CommandError, match="this is a replay"):
        check(GOAL, program)
