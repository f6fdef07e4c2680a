"""A state that was kept goes on exactly as it would have gone on."""

import numpy as np
import pytest

from app.engine.build import build_program
from app.engine.checkpoint import LARGE, CheckpointError, CheckpointWriter
from app.engine.localization import Localization
from app.engine.parameter_changes import changed
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from robot.localization.filter_kinds import FILTERS
from robot.localization.parameters import LocalizationParameters


@pytest.fixture(scope="module")
def drive():
    """A program, and the frames with odometry of some seconds of it."""
    program = build_program(Config(robot="kinematic"))
    frames = []
    engine = program.engine
    measure = engine.localization.measure
    engine.localization.measure = lambda frame, then: frames.append((frame, then))
    for _ in range(220):
        engine.commands.put(FigureEightCommand(type="figure_eight"))
        engine.step()
    engine.localization.measure = measure
    return program, frames


def localization_of(program, kind, added=()):
    parameters = changed(LocalizationParameters(), {"filter": kind})
    return Localization(
        program.engine.localization.scanner,
        program.field,
        parameters,
        np.random.default_rng(3),
        added=added,
        entries=program.engine.localization.models.entries,
    )


def keeper_of(program, localization):
    return CheckpointWriter([program.field, program.field.edges, *localization.added])


def answers(localization, frames):
    found = []
    for frame, then in frames:
        localization.measure(frame, then)
        belief = localization.belief
        estimate = None if belief is None else belief.estimate
        found.append((estimate, localization.cloud))
    return found


def assert_same(some, others):
    assert len(some) == len(others)
    for (estimate, cloud), (other, other_cloud) in zip(some, others, strict=True):
        assert (estimate is None) == (other is None)
        if estimate is not None:
            assert estimate.pose == other.pose
            assert np.array_equal(estimate.covariance, other.covariance)
            assert len(estimate.hypotheses) == len(other.hypotheses)
        assert np.array_equal(cloud.poses, other_cloud.poses)
        assert np.array_equal(cloud.weights, other_cloud.weights)


@pytest.mark.slow
@pytest.mark.parametrize("scattered", [False, True], ids=["told", "scattered"])
@pytest.mark.parametrize("kind", FILTERS)
def test_a_filter_goes_on_bit_for_bit_as_it_would_have(drive, kind, scattered):
    program, frames = drive
    straight = localization_of(program, kind)
    if scattered:
        straight.scatter()
    keeper = keeper_of(program, straight)
    answers(straight, frames[:40])
    checkpoint = keeper.keep(straight)
    expected = answers(straight, frames[40:])
    # Twice: what was brought back before must not have changed what was kept.
    for _ in range(2):
        assert_same(answers(checkpoint.restore(), frames[40:]), expected)


def test_a_search_for_places_can_be_kept_in_the_middle_of_it(drive):
    program, frames = drive
    straight = localization_of(program, "hypotheses")
    straight.scatter()
    keeper = keeper_of(program, straight)
    seen = 0
    while straight.localizer.filter._searches._running is None or seen % 2 == 0:
        answers(straight, frames[seen : seen + 1])
        seen += 1
    answers(straight, frames[seen : seen + 3])
    assert straight.localizer.filter._searches._running is not None, (
        "the search should still be at work"
    )
    checkpoint = keeper.keep(straight)
    expected = answers(straight, frames[seen + 3 :])
    assert straight.localizer.filter.hypotheses, "nothing was found: the test tells nothing"
    assert_same(answers(checkpoint.restore(), frames[seen + 3 :]), expected)


def test_what_never_changes_is_not_copied(drive):
    program, _ = drive
    straight = localization_of(program, "hypotheses")
    restored = keeper_of(program, straight).keep(straight).restore()
    assert restored is not straight
    assert restored._field is program.field
    assert restored.scanner is straight.scanner
    assert restored.models.entries is straight.models.entries
    assert restored.added == straight.added
    mine, other = straight.localizer.filter, restored.localizer.filter
    assert mine.setup.matcher is other.setup.matcher
    assert mine.setup.sensor is other.setup.sensor


def test_generators_that_were_one_are_one_again(drive):
    program, _ = drive
    straight = localization_of(program, "hypotheses")
    restored = keeper_of(program, straight).keep(straight).restore()
    assert restored._rng is not straight._rng
    assert restored._rng is restored.localizer.filter._rng
    assert restored._rng is restored.localizer.filter._new_filter.rng
    assert restored._rng is restored.localizer.filter._tracks[0].filter._rng


def test_large_arrays_that_are_the_same_are_kept_once():
    keeper = CheckpointWriter([])
    table = np.arange(LARGE, dtype=np.float64)
    first, second = keeper.keep({"table": table, "n": 1}), keeper.keep({"table": table, "n": 2})
    assert first.blocks[0] is second.blocks[0]
    brought = second.restore()
    brought["table"][0] = 7.0
    assert first.restore()["table"][0] == 0.0


def test_what_cannot_be_copied_is_refused_in_words():
    with pytest.raises(CheckpointError, match="cannot be kept"):
        CheckpointWriter([]).keep({"model": lambda: None})
