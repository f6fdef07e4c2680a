"""The filter runs again on a recording, and what it says depends on nothing but time."""

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run
from recordings import record
from replays import course_of, gist, go, recorded_eight, to_the_end

from app.features.plausibility.checks import PlausibilityChecks
from app.features.recordings.replay.timeline import Checkpoints
from app.messages.commands import ResetCommand, SetParametersCommand, SetPoseCommand


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return recorded_eight(tmp_path_factory.mktemp("recordings"))


@pytest.fixture(scope="module")
def straight(recording):
    """What a replay says at each of its ticks, without any going back and forth."""
    return to_the_end(course_of(recording[0]))


@pytest.mark.slow
def test_it_has_every_tick_and_the_truth_of_then(recording, straight):
    _, shown = recording
    assert len(straight) == len(shown)
    for mine, then in zip(straight, shown, strict=True):
        assert mine.stamp == pytest.approx(then.stamp - shown[0].stamp, abs=1e-6)
        assert mine.truth.distance_to(then.truth) < 1e-4
        assert mine.twist.v == pytest.approx(then.twist.v, abs=1e-9)


def test_it_says_about_what_was_said_then_once_it_knows_the_place(recording, straight):
    _, shown = recording
    apart = [a.pose.distance_to(b.pose) for a, b in zip(straight, shown, strict=True)]
    # Half of the pictures, and as JPEG: it finds the place a little later, and the same one.
    assert np.median(apart) < 0.0005
    assert max(apart[150:]) < 0.002


@pytest.mark.slow
def test_what_was_said_then_is_told_beside_it(recording):
    _, shown = recording
    timeline = course_of(recording[0])
    apart = []
    for one, then in zip(timeline.ticks_up_to(2**62), shown, strict=True):
        apart.append(timeline.estimate_then(one).distance_to(then.pose))
    assert max(apart) < 1e-6


@pytest.mark.slow
def test_the_same_file_settings_and_seed_give_the_same_bit_for_bit(recording, straight):
    again = to_the_end(course_of(recording[0]))
    assert [gist(one) for one in again] == [gist(one) for one in straight]


@pytest.mark.slow
def test_another_seed_is_other_luck(recording, straight):
    other = to_the_end(course_of(recording[0], seed=99))
    assert gist(other[-1]) != gist(straight[-1])
    assert other[-1].pose.distance_to(straight[-1].pose) < 0.002


@pytest.mark.slow
def test_other_parameters_give_another_result(recording, straight, tmp_path):
    path = tmp_path / "few.toml"
    path.write_text("[localization.filter]\nmax_particles = 60\nmin_particles = 60\n")
    few = to_the_end(course_of(recording[0], filter_config=path))
    assert len(few[0].filter.cloud.weights) <= 60 < len(straight[0].filter.cloud.weights)
    assert few[-1].filter.parameters.filter.max_particles == 60


@pytest.mark.slow
def test_what_scans_have_left_in_features_is_that_of_the_time(recording):
    timeline = course_of(recording[0])
    (checks,) = (m for m in timeline.engine.localization.added if isinstance(m, PlausibilityChecks))
    for seconds in (5.5, 0.0, 4.0, 1.0):
        shown = go(timeline, seconds)
        assert shown.stamp - 0.2 < checks.memory.stamp <= shown.stamp
        assert (checks.memory.motion is None) == (seconds == 0.0)


@pytest.mark.slow
def test_wherever_one_comes_from_the_answer_is_that_of_a_straight_run(recording, straight):
    by_stamp = {one.stamp: gist(one) for one in straight}
    timeline = course_of(recording[0])
    rng = np.random.default_rng(5)
    for seconds in [0.0, 9.5, *rng.uniform(0, 10, 20).tolist(), 99.0, 0.0]:
        shown = go(timeline, seconds)
        assert gist(shown) == by_stamp[shown.stamp], f"at {seconds} s"
    assert len(timeline.checkpoints) >= 4


def test_to_go_back_starts_near_the_place_and_not_at_the_beginning(recording):
    timeline = course_of(recording[0])
    go(timeline, 9.5)
    timeline.go_near(timeline.robot.start_ns + 8_000_000_000)
    before = (timeline.robot.start_ns + 8_000_000_000 - timeline.log_ns) / 1e9
    assert 0 < before < 3


def test_a_pose_that_is_told_acts_until_one_goes_elsewhere(recording, straight):
    by_stamp = {one.stamp: gist(one) for one in straight}
    timeline = course_of(recording[0])
    go(timeline, 6.0)
    far = SetPoseCommand(type="set_pose", x=0.3, y=0.3, theta=1.0, sd_xy=0.001, sd_theta=0.001)
    told = timeline.tick((far,))
    assert np.hypot(*(told.filter.cloud.poses[:, :2] - [0.3, 0.3]).T).max() < 0.05
    after = go(timeline, 5.0)
    assert gist(after) == by_stamp[after.stamp]


def test_parameters_that_are_set_act_at_once_and_hold_for_the_whole_replay(recording, straight):
    timeline = course_of(recording[0])
    go(timeline, 6.0)
    values = {"max_particles": 300, "min_particles": 300, "filter": "particles"}
    now = timeline.tick((SetParametersCommand(type="set_parameters", values=values),))
    assert now.filter.parameters.filter.max_particles == 300
    shown = go(timeline, 3.0)
    assert shown.filter.parameters.filter.max_particles == 300
    anew = course_of(recording[0])
    anew.change(SetParametersCommand(type="set_parameters", values=values))
    assert gist(go(anew, 3.0)) == gist(shown)
    # And back to those of then.
    timeline.tick((ResetCommand(type="reset"),))
    back = go(timeline, 3.0)
    assert gist(back) == {one.stamp: gist(one) for one in straight}[back.stamp]


@pytest.mark.slow
def test_own_models_are_used_for_the_whole_replay_and_taken_anew_when_saved(
    recording, straight, save
):
    flat = """
    import numpy as np
    class Mine:
        def log_likelihood(self, poses, scan):
            return np.zeros(len(poses))
    """
    path = save(flat)
    timeline = course_of(recording[0], sensor_model=f"{path}:Mine")
    shown = go(timeline, 4.0)
    assert shown.filter.models.sensor == "mine.py:Mine"
    assert gist(shown) != {one.stamp: gist(one) for one in straight}[shown.stamp]
    checkpoints = len(timeline.checkpoints)
    save(flat.replace("np.zeros(len(poses))", "-100 * np.abs(poses[:, 0])"))
    timeline.apply_between_ticks(())
    timeline.apply_between_ticks(())
    assert checkpoints and not len(timeline.checkpoints), "they were of the model before"
    assert gist(go(timeline, 4.0)) != gist(shown)


@pytest.mark.slow
def test_a_model_that_keeps_something_is_kept_with_it(recording, save):
    path = save(
        """
        import numpy as np
        class Counting:
            def __init__(self):
                self.asked = 0
            def log_likelihood(self, poses, scan):
                self.asked += 1
                return -self.asked * np.abs(poses[:, 0])
        """
    )
    model = f"{path}:Counting"
    there_and_on = to_the_end(course_of(recording[0], sensor_model=model))
    straight = {one.stamp: gist(one) for one in there_and_on}
    timeline = course_of(recording[0], sensor_model=model)
    for seconds in (8.0, 5.0, 9.5, 6.3):
        shown = go(timeline, seconds)
        assert gist(shown) == straight[shown.stamp]
    assert len(timeline.checkpoints) > 3


def test_a_model_that_cannot_be_copied_makes_it_slow_and_not_wrong(recording, save):
    path = save(
        """
        import numpy as np
        class Local:
            def __init__(self):
                self.scale = lambda x: -np.abs(x)
            def log_likelihood(self, poses, scan):
                return self.scale(poses[:, 0])
        """
    )
    timeline = course_of(recording[0], sensor_model=f"{path}:Local")
    later = go(timeline, 3.0)
    assert len(timeline.checkpoints) == 0
    assert any("To go back takes long" in one.message for one in later.problems.record)
    first = gist(go(timeline, 1.0))
    assert gist(go(course_of(recording[0], sensor_model=f"{path}:Local"), 1.0)) == first


def test_steps_go_from_picture_to_picture(recording, straight):
    pictures = [one.stamp for one in straight if one.reading.frame is not None]
    timeline = course_of(recording[0])
    go(timeline, pictures[40])
    *_, shown = timeline.ticks_with_pictures(3)
    assert shown.stamp == pictures[43]
    assert timeline.picture_before(5) == timeline.robot.start_ns + round(pictures[38] * 1e9)
    assert timeline.picture_before(1000) == timeline.robot.start_ns


@pytest.mark.slow
def test_a_recording_of_the_middle_of_a_run_begins_with_what_was_estimated_first(tmp_path):
    program = kinematic(seed=1, map="stub")
    run(program, 3.0, EIGHT)
    made, shown, _ = record(program, tmp_path, 2, EIGHT)
    assert shown[0].truth.distance_to(program.field.start) > 0.2, "it would not tell the two apart"
    again = to_the_end(course_of(made))
    apart = [a.pose.distance_to(b.pose) for a, b in zip(again, shown, strict=True)]
    assert max(apart) < 0.01
    assert again[0].odometry.distance_to(shown[0].pose) < 0.01


def test_checkpoints_are_thinned_out_where_they_are_large(recording):
    timeline = course_of(recording[0])
    timeline.checkpoints = Checkpoints(most_bytes=600_000)
    to_the_end(timeline)
    assert 1 <= len(timeline.checkpoints) < 4
    assert timeline.checkpoints.size <= 600_000
