"""Steps of the filter by hand are recorded, and a replay repeats them, also after going back."""

from __future__ import annotations

import pytest
from engine_runs import kinematic, run
from recordings import begin, recorder_of
from replays import course_of, gist, go, to_the_end

from app.features.weighing.messages import FilterByHandCommand, FilterStepCommand, FilterUndoCommand
from app.messages.commands import SetParametersCommand
from app.messages.driving_commands import FigureEightCommand
from sim.simulated import PERIOD

ON = FilterByHandCommand(type="filter_by_hand", on=True)
PREDICT, WEIGH, RESAMPLE = (
    FilterStepCommand(type="filter_step", step=step) for step in ("predict", "weigh", "resample")
)
GIVEN = {
    0.2: SetParametersCommand(type="set_parameters", values={"filter": "particles"}),
    0.6: ON,
    1.0: PREDICT,
    1.2: WEIGH,
    1.4: FilterUndoCommand(type="filter_undo"),
    1.6: WEIGH,
    1.8: RESAMPLE,
    2.6: FilterByHandCommand(type="filter_by_hand", on=False),
}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Three seconds of a figure-eight, the filter by hand for two of them; and the snapshots."""
    program = kinematic(seed=1)
    recorder, publisher = recorder_of(program, tmp_path_factory.mktemp("recordings"))
    folder = begin(recorder, publisher)
    due = {round(seconds / PERIOD): command for seconds, command in GIVEN.items()}
    shown = []
    for tick in range(round(3.0 / PERIOD)):
        eight = FigureEightCommand(type="figure_eight")
        given = (due[tick],) if tick in due else ()
        shown.append(run(program, PERIOD, eight, *given)[-1])
        publisher.tick(shown[-1])
    recorder.close()
    return folder, shown


def step_of(snapshot) -> str | None:
    if snapshot.filter.hand is None:
        return "by itself"
    return snapshot.filter.hand.last and snapshot.filter.hand.last.step


def test_a_replay_takes_the_same_steps_at_the_same_times(recording) -> None:
    folder, recorded = recording
    replayed = to_the_end(course_of(folder))
    assert [step_of(shown) for shown in replayed] == [step_of(shown) for shown in recorded]
    for shown, then in zip(replayed, recorded, strict=True):
        if shown.filter.hand and then.filter.hand:
            # A recording has every second picture only: a prediction ends at the one before.
            assert shown.filter.hand.ahead.x == pytest.approx(then.filter.hand.ahead.x, abs=0.011)


def test_going_back_into_the_steps_shows_the_same_particles(recording) -> None:
    folder, _ = recording
    timeline = course_of(folder)
    straight = {shown.stamp: (gist(shown), step_of(shown)) for shown in to_the_end(timeline)}
    for seconds in (1.3, 0.9, 1.7, 2.0, 1.1):
        shown = go(timeline, seconds)
        assert (gist(shown), step_of(shown)) == straight[shown.stamp]


def test_a_viewer_steps_a_recording_by_hand(recording) -> None:
    folder, _ = recording
    timeline = course_of(folder)
    go(timeline, 0.5)
    timeline.apply_between_ticks((ON,))
    before = timeline.tick()
    assert step_of(before) is None
    shown = [timeline.apply_between_ticks((command,)) for command in (PREDICT, WEIGH, RESAMPLE)]
    assert [step_of(one) for one in shown] == ["predict", "weigh", "resample"]
    back = [timeline.apply_between_ticks((FilterUndoCommand(type="filter_undo"),)) for _ in shown]
    assert [step_of(one) for one in back] == ["weigh", "predict", None]
    assert back[-1].filter.cloud.poses.tobytes() == before.filter.cloud.poses.tobytes()
    again = timeline.apply_between_ticks((PREDICT,))
    assert again.filter.cloud.poses.tobytes() == shown[0].filter.cloud.poses.tobytes()
