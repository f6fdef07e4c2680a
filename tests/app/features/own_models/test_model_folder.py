"""Models dropped into a folder: offered by the page, chosen live."""

import pytest
from engine_runs import EIGHT
from own_programs import FLAT, STILL, run

from app.engine.added_models import ModelChoice
from app.engine.commands import check
from app.messages.commands import SetParametersCommand
from app.page.parameters import parameter_messages
from app.settings.config import Config
from robot.errors import CommandError


def test_models_dropped_into_the_folder_are_offered_and_chosen_live(save, tmp_path, with_own):
    program = with_own(folder=tmp_path)
    assert run(program, 0.3).filter.models == ModelChoice()
    save(FLAT)
    save(STILL, "still.py")
    shown = run(program, 0.5)
    assert (shown.filter.models.sensors, shown.filter.models.motions) == (
        ("mine.py:Flat",),
        ("still.py:Still",),
    )
    values = {"laser_model_type": "mine.py:Flat", "robot_model_type": "still.py:Still"}
    command = SetParametersCommand(type="set_parameters", values=values)
    check(command, program)
    program.engine.commands.put(command)
    shown = run(program, 0.5, EIGHT)
    assert (shown.filter.models.sensor, shown.filter.models.motion) == (
        "mine.py:Flat",
        "still.py:Still",
    )
    messages = parameter_messages(
        shown.filter.parameters, Config().localization, shown.filter.models, program.given
    )
    sensor = next(one for one in messages if one.name == "laser_model_type")
    assert sensor.value == "mine.py:Flat"
    assert sensor.choices[-1] == "mine.py:Flat"
    assert sensor.default == "likelihood_field"


def test_a_model_in_use_stays_on_offer_when_its_file_goes(save, tmp_path, with_own):
    path = save(FLAT)
    program = with_own(path, folder=tmp_path)
    run(program, 0.5, EIGHT)
    path.unlink()
    shown = run(program, 1.0, EIGHT)
    assert shown.filter.fault is None
    assert shown.filter.models.sensors == ("mine.py:Flat",)


def test_a_file_that_is_no_python_is_told_and_stops_nothing(save, tmp_path, with_own):
    save("def x(:", "other.py")
    shown = run(with_own(folder=tmp_path), 0.5, EIGHT)
    assert shown.problems.present == ("other.py line 1: SyntaxError: invalid syntax",)
    assert shown.twist.v > 0


def test_a_model_that_is_not_on_offer_is_refused(save, tmp_path, with_own):
    save(FLAT)
    program = with_own(folder=tmp_path)
    run(program, 0.1)
    values = {"laser_model_type": "mine.py:Round"}
    with pytest.raises(CommandError, match=r"on offer: mine\.py:Flat"):
        check(SetParametersCommand(type="set_parameters", values=values), program)


def test_a_model_that_vanished_since_it_was_chosen_stops_nothing(save, tmp_path, with_own):
    path = save(FLAT)
    program = with_own(folder=tmp_path)
    run(program, 0.3)
    path.unlink()
    values = {"laser_model_type": "mine.py:Flat"}
    run(program, 0.4)
    program.engine.commands.put(SetParametersCommand(type="set_parameters", values=values))
    shown = program.engine.step()
    assert "A change was not taken" in shown.problems.present[0]
    assert shown.filter.models.sensor == ""
