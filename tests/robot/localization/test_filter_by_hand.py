"""The filter by hand does what it does by itself, bit for bit, and takes back what it did."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from engine_runs import drive, kinematic, run
from particle_robot import Tracker, tracker_of
from stub_drive import DEFAULTS, Drive

from app.engine.earlier_beliefs import MOST_BYTES
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.engine.steps_by_hand import MOST_STEPS
from app.features.weighing.messages import FilterByHandCommand, FilterStepCommand, FilterUndoCommand
from app.messages.commands import ResetCommand, ScatterCommand, SetParametersCommand
from robot.errors import CommandError
from robot.geometry import Pose2, Twist2, compose
from robot.localization.estimate import Hypothesis
from robot.localization.filter_by_hand import FilterByHand, StepError
from robot.localization.particles.clusters import Cells, find_clusters
from robot.localization.particles.resampling import Resampled, low_variance, regularize

pytestmark = pytest.mark.slow

ON = FilterByHandCommand(type="filter_by_hand", on=True)
OFF = FilterByHandCommand(type="filter_by_hand", on=False)
PREDICT, WEIGH, RESAMPLE = (
    FilterStepCommand(type="filter_step", step=step) for step in ("predict", "weigh", "resample")
)
UNDO = FilterUndoCommand(type="filter_undo")
PARTICLES = SetParametersCommand(type="set_parameters", values={"filter": "particles"})


def steps(odometry_and_scans: int = 6) -> list[tuple[Pose2, object]]:
    robot = Drive()
    result = []
    for _ in range(odometry_and_scans):
        _, scan = robot.step(Twist2(0.15, 0.4))
        result.append((robot.odometry, scan))
    return result


def content(tracker: Tracker) -> tuple:
    f = tracker.filter
    return (
        f.particles.poses.tobytes(),
        f.particles.weights.tobytes(),
        f.cloud.weights.tobytes(),
        f._rng.bit_generator.state,
        tracker.updates,
        pickle.dumps(tracker.integrity),
    )


# --- the same numbers


@pytest.mark.parametrize("changes", [{}, {"regularization": 0.0}, {"max_particles": 500}])
def test_three_steps_by_hand_are_one_update_bit_for_bit(changes: dict) -> None:
    alone, stepped = tracker_of(seed=3, **changes), tracker_of(seed=3, **changes)
    by_hand = FilterByHand(stepped)
    for odometry, scan in steps():
        expected = alone.update(odometry, scan)
        by_hand.predict(scan, odometry)
        estimate = by_hand.weigh()
        by_hand.resample()
        assert content(stepped) == content(alone)
        assert estimate is not None and expected is not None
        assert estimate.pose == expected.pose
        assert estimate.covariance.tobytes() == expected.covariance.tobytes()
        assert estimate.effective == expected.effective


def test_a_prediction_uses_all_of_the_motion_since_the_last() -> None:
    tracker = tracker_of()
    by_hand = FilterByHand(tracker)
    drive_on = steps(10)
    by_hand.predict(drive_on[0][1], drive_on[0][0])
    by_hand.predict(drive_on[-1][1], drive_on[-1][0])
    assert by_hand.last is not None and by_hand.last.noiseless is not None
    whole = drive_on[0][0].inverse() @ drive_on[-1][0]
    assert by_hand.last.moved == whole
    noiseless = compose(by_hand.last.before.poses, whole.to_array())
    assert np.array_equal(by_hand.last.noiseless, noiseless)
    noise = by_hand.last.after.poses[:, :2] - noiseless[:, :2]
    assert 1e-5 < noise.std() < 0.05


def test_a_step_out_of_order_is_refused_and_changes_nothing() -> None:
    tracker = tracker_of()
    by_hand = FilterByHand(tracker)
    before = content(tracker)
    with pytest.raises(StepError, match="predict first"):
        by_hand.weigh()
    with pytest.raises(StepError, match="weigh first"):
        by_hand.resample()
    assert content(tracker) == before
    odometry, scan = steps(1)[0]
    by_hand.predict(scan, odometry)
    with pytest.raises(StepError, match="weigh first"):
        by_hand.resample()
    by_hand.weigh()
    with pytest.raises(StepError, match="predict first"):
        by_hand.weigh()
    by_hand.resample()
    with pytest.raises(StepError, match="weigh first"):
        by_hand.resample()


# --- who comes of whom


@pytest.mark.parametrize("scale", [0.0, 1e-9])
def test_each_copy_has_its_parent(scale: float) -> None:
    """Few copies of each cluster: those are spread, but not stretched, so that it shows exactly."""
    rng = np.random.default_rng(5)
    centres = np.array([[0, 0, 0], [1, 0, 1], [0, 1, -2], [2, 2, 3], [3, 0, 0.5]])
    poses = centres[rng.integers(5, size=24)] + rng.normal(0, 0.01, (24, 3))
    weights = rng.random(24)
    weights /= weights.sum()
    clusters = find_clusters(poses, weights, Cells(0.1, 36), most=3)
    assert len(clusters.means) == 3  # two are not described
    drawn = low_variance(weights, 20, rng)
    copies = regularize(poses, clusters, drawn, scale, rng)
    renewed = np.zeros(20, dtype=bool)
    renewed[4] = True
    parents = Resampled(clusters, drawn, renewed, in_order=scale == 0).parents
    assert parents[4] == -1
    kept = ~renewed
    assert np.abs(copies[kept] - poses[parents[kept]]).max() < 1e-6
    assert scale == 0 or (np.diff(drawn) >= 0).all() != (np.diff(parents[kept]) >= 0).all()


def test_the_heavy_have_copies_and_some_of_the_light_die() -> None:
    tracker = tracker_of(seed=1)
    by_hand = FilterByHand(tracker)
    odometry, scan = steps(1)[0]
    by_hand.predict(scan, odometry)
    by_hand.weigh()
    weights = tracker.filter.particles.weights
    by_hand.resample()
    assert by_hand.last is not None and by_hand.last.parents is not None
    copies = np.bincount(by_hand.last.parents, minlength=len(weights))
    assert copies.sum() == len(by_hand.last.after.weights)
    wanted = len(by_hand.last.after.weights) * weights
    assert (np.abs(copies - wanted) < 1).all()  # low variance: rounded up or down
    assert (copies == 0).any()


# --- in the engine


@pytest.fixture
def program() -> Program:
    made = kinematic(map="square")
    made.engine.commands.put(PARTICLES)
    run(made, 0.5, drive(v=0.1, omega=0.3))
    run(made, 0.7)
    made.engine.commands.put(ON)
    run(made, 0.1)
    return made


def give(program: Program, *commands) -> Snapshot:
    for command in commands:
        program.engine.commands.put(command)
    return program.engine.step()


def belief(program: Program) -> tuple:
    localization = program.engine.localization
    f = localization.localizer.filter
    return (
        f.particles.poses.tobytes(),
        f.particles.weights.tobytes(),
        localization._rng.bit_generator.state,
        f._rng is localization._rng,
        pickle.dumps(localization.belief),
    )


def test_by_hand_the_filter_waits_while_the_robot_drives(program: Program) -> None:
    before = belief(program)
    shown = run(program, 0.5, drive(v=0.1))
    assert belief(program) == before
    assert shown[-1].filter.hand is not None and shown[-1].filter.hand.last is None
    assert 0.03 < shown[-1].filter.hand.ahead.x < 0.05
    after = give(program, PREDICT)
    assert after.filter.hand is not None and after.filter.hand.last is not None
    assert after.filter.hand.last.moved.x == pytest.approx(shown[-1].filter.hand.ahead.x, abs=0.004)
    assert after.filter.hand.ahead.x < 0.008
    # The particles stand where the robot was at the picture before.
    weighed = give(program, WEIGH)
    assert weighed.filter.hand is not None and weighed.filter.weighing is not None
    assert weighed.filter.hand.effective < len(weighed.filter.cloud.weights)
    resampled = give(program, RESAMPLE)
    assert resampled.filter.hand is not None
    assert resampled.filter.hand.effective == pytest.approx(len(resampled.filter.cloud.weights))
    assert resampled.pose is not None and resampled.truth is not None
    # The wall ahead says how far the robot went, not how far it is along it.
    assert abs((resampled.pose.inverse() @ resampled.truth).x) < 0.005


def test_undo_restores_all_bit_for_bit_and_the_same_step_draws_the_same(program: Program) -> None:
    kept = [belief(program)]
    taken = []
    for command in (PREDICT, WEIGH, RESAMPLE, PREDICT, WEIGH):
        taken.append(give(program, command))
        kept.append(belief(program))
    assert len({item[0] + item[1] for item in kept}) > 3
    for before, last in zip(reversed(kept[:-1]), reversed([None, *taken[:-1]]), strict=True):
        back = give(program, UNDO)
        assert belief(program) == before
        assert back.filter.hand is not None
        assert (back.filter.hand.last and back.filter.hand.last.step) == (
            last and last.filter.hand and last.filter.hand.last and last.filter.hand.last.step
        )
    assert back.filter.hand.undoable == 0
    for command, after in zip((PREDICT, WEIGH, RESAMPLE, PREDICT, WEIGH), kept[1:], strict=True):
        give(program, command)
        assert belief(program) == after
    numbers = [item.filter.hand.number for item in taken if item.filter.hand]
    assert len(set(numbers)) == len(numbers)


def test_what_cannot_be_done_is_noted_and_nothing_else_stops(program: Program) -> None:
    shown = give(program, WEIGH)
    assert shown.problems.record[-1].message == (
        "A step by hand was not taken: there is no new scan to weigh by; predict first."
    )
    assert "no step by hand to take back" in give(program, UNDO).problems.record[-1].message
    off = give(program, OFF)
    assert off.filter.hand is None
    assert "switch filter_by_hand on" in give(program, PREDICT).problems.record[-1].message
    assert run(program, 0.5, drive(v=0.1))[-1].filter.updates > off.filter.updates


def test_another_belief_begins_the_steps_anew(program: Program) -> None:
    give(program, PREDICT)
    scattered = give(program, ScatterCommand(type="scatter"))
    assert scattered.filter.hand is not None
    assert scattered.filter.hand.last is None and scattered.filter.hand.undoable == 0
    assert give(program, ResetCommand(type="reset")).filter.hand is None


def test_only_the_particle_filter_has_steps_by_hand() -> None:
    from app.engine.commands import check

    program = kinematic()
    run(program, 0.1)
    for command in (PREDICT, UNDO):
        with pytest.raises(CommandError, match="hypotheses has no steps by hand; choose particles"):
            check(command, program)
    # By hand, it takes the place of another filter, and begins where that is.
    before = run(program, 0.1)[-1]
    by_hand = give(program, ON)
    assert by_hand.filter.parameters.filter.filter == "particles"
    assert by_hand.filter.hand is not None
    mean = by_hand.filter.hand.particles.poses[:, :2].mean(axis=0)
    assert np.hypot(*(mean - [before.pose.x, before.pose.y])) < 0.05


def test_by_hand_begins_at_the_heaviest_place_of_several() -> None:
    program = kinematic()
    run(program, 0.1)
    places = [
        Hypothesis(share, Pose2(x, 0.2, 0.5), np.diag([0.01, 0.01, 0.02]) ** 2)
        for share, x in ((0.3, -0.3), (0.7, 0.3))
    ]
    program.engine.controls.localization.localizer.set_hypotheses(tuple(places))
    by_hand = give(program, ON).filter.hand
    assert by_hand is not None
    assert np.abs(by_hand.particles.poses[:, 0] - 0.3).max() < 0.1


def test_another_filter_ends_the_steps_by_hand(program: Program) -> None:
    kalman = SetParametersCommand(type="set_parameters", values={"filter": "kalman"})
    assert give(program, kalman).filter.hand is None


def test_the_defaults_resample_at_each_update() -> None:
    """What the page says of one update being three steps holds for these."""
    assert DEFAULTS.filter.resample_interval == 1 and not DEFAULTS.filter.selective_resampling


def test_many_steps_of_many_particles_fill_no_memory(program: Program) -> None:
    many = {"max_particles": 20_000, "min_particles": 20_000}
    give(program, SetParametersCommand(type="set_parameters", values=many))
    give(program, ScatterCommand(type="scatter"))
    for _ in range(30):
        shown = give(program, PREDICT, WEIGH, RESAMPLE)
    assert shown.filter.hand is not None
    assert 20 < shown.filter.hand.undoable <= MOST_STEPS
    beliefs = program.engine.localization.by_hand._earlier._beliefs
    assert sum(belief.size for belief in beliefs) <= MOST_BYTES
    assert give(program, UNDO).filter.hand.undoable == shown.filter.hand.undoable - 1  # type: ignore[union-attr]
