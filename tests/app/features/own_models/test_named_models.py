"""Named models of a package: chosen, made, put back, and their faults told by file and line."""

import re
from dataclasses import replace

import numpy as np
import pytest
from engine_runs import EIGHT, kinematic
from own_programs import run, undoubted, with_added

from app.engine.commands import check
from app.features.own_models.named_models import NamedModels
from app.messages.commands import ResetCommand, SetParametersCommand
from robot.errors import CommandError


class East:
    """Prefers the east."""

    def __init__(self, parameters):
        self.scale = 10 / parameters.sigma_hit

    def log_likelihood(self, poses, scan):
        return self.scale * poses[:, 0]


class Broken:
    """Fails when it is asked."""

    def log_likelihood(self, poses, scan):
        return poses[:, 7]


class Choosy:
    """Cannot be made."""

    def __init__(self, laser):
        self.laser = laser


class Jumps:
    """Moves all particles east."""

    def sample(self, poses, moved, rng):
        return poses + np.array([0.01, 0.0, 0.0])


@pytest.fixture(scope="module")
def base():
    return kinematic()


@pytest.fixture
def program(base):
    sensors = {"east": East, "broken": Broken, "choosy": Choosy}
    return with_added(base, NamedModels(base.field, sensors=sensors, motions={"jumps": Jumps}))


def choose(program, **values):
    command = SetParametersCommand(type="set_parameters", values=values)
    check(command, program)
    program.engine.commands.put(command)


def test_they_are_offered_and_used_as_long_as_they_are_chosen(program):
    shown = run(program, 0.3)
    assert shown.filter.models.sensors == ("east", "broken", "choosy")
    assert shown.filter.models.motions == ("jumps",)
    choose(program, laser_model_type="east", robot_model_type="jumps")
    shown = run(program, 1.0, EIGHT)
    assert (shown.filter.models.sensor, shown.filter.models.motion) == ("east", "jumps")
    cloud = shown.filter.cloud
    assert np.corrcoef(cloud.poses[:, 0], cloud.weights)[0, 1] > 0.5
    assert cloud.poses[:, 0].mean() > 0.05
    (added,) = program.engine.localization.added
    scale = added.in_use[0].guard._method.__self__.scale
    choose(program, sigma_hit=2 * shown.filter.parameters.sensor.sigma_hit)
    run(program, 0.1)
    assert added.in_use[0].guard._method.__self__.scale == pytest.approx(scale / 2)
    choose(program, laser_model_type="beam", robot_model_type="omni")
    assert run(program, 0.1).filter.models == replace(shown.filter.models, sensor="", motion="")
    assert added.in_use == (None, None)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("broken", r"test_named_models\.py line 31: IndexError: "),
        ("choosy", r"test_named_models\.py line 37: Choosy asks for laser; on offer: edges, "),
    ],
)
def test_one_that_fails_stops_the_robot_until_another_is_chosen(program, name, words):
    choose(program, laser_model_type=name)
    shown = run(program, 0.5, EIGHT)
    (problem,) = undoubted(shown)
    assert shown.mode == "idle"
    assert shown.filter.fault is not None and problem.endswith(shown.filter.fault)

    assert re.match("The robot stands still: " + words, problem)
    program.engine.commands.put(ResetCommand(type="reset"))
    shown = run(program, 0.5, EIGHT)
    assert (shown.filter.fault, shown.mode) == (None, "figure_eight")


def test_a_name_of_nobody_is_refused(program):
    with pytest.raises(CommandError, match="laser_model_type is 'west'; valid are"):
        choose(program, laser_model_type="west")


def test_what_was_in_use_is_put_back(program):
    choose(program, laser_model_type="east")
    run(program, 0.1)
    (added,) = program.engine.localization.added
    before = added.in_use
    parameters = program.engine.localization.parameters
    other = replace(parameters, sensor=replace(parameters.sensor, sigma_hit=0.004))
    added.make(other, fresh=False)
    assert added.in_use != before
    added.put_back(before, parameters)
    added.make(parameters, fresh=False)
    assert added.in_use == before
    added.make(other, fresh=False)
    assert added.in_use != before
