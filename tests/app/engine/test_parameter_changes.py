"""What the page sends changes parameters by name, all or none."""

import math

import pytest

from app.engine.added_models import ModelChoice
from app.engine.parameter_changes import changed, with_values_and_models
from robot.localization.parameters import LocalizationParameters
from robot.settings import SettingError

DEFAULT = LocalizationParameters()


def test_values_reach_their_group_by_name_alone():
    result = changed(DEFAULT, {"max_particles": 700, "sigma_hit": 0.01, "do_beamskip": True})
    assert (result.filter.max_particles, result.sensor.sigma_hit) == (700, 0.01)
    assert result.sensor.do_beamskip
    assert result.motion == DEFAULT.motion
    assert changed(DEFAULT, {}) == DEFAULT


@pytest.mark.parametrize("value", [700, 700.0])
def test_a_whole_number_is_one_however_it_is_written(value):
    count = changed(DEFAULT, {"max_particles": value}).filter.max_particles
    assert (count, type(count)) == (700, int)
    spread = changed(DEFAULT, {"alpha2": value}).motion.alpha2
    assert (spread, type(spread)) == (700.0, float)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"max_particle": 700}, "^max_particle is unknown; valid are .*max_particles"),
        ({"max_particles": 700.5}, "^max_particles is 700.5; valid is a whole number"),
        ({"max_particles": math.nan}, "^max_particles is nan; valid is a whole number"),
        ({"max_particles": True}, "^max_particles is True; valid is a whole number"),
        ({"max_particles": "700"}, "^max_particles is '700'; valid is a whole number"),
        ({"max_particles": 1e300}, "^max_particles is 1e.300; valid is 10 to 20000"),
        ({"sigma_hit": True}, "^sigma_hit is True; valid is a number"),
        ({"sigma_hit": 9}, "^sigma_hit is 9 m; valid is 0.0005 to 0.5 m"),
        ({"refine": 1}, "^refine is 1; valid is true or false"),
        ({"filter": "best"}, "^filter is 'best'; valid are hypotheses, particles"),
        ({"sigma_hit": 0.01, "max_particles": 1}, "^max_particles is 1; valid is"),
    ],
)
def test_a_wrong_name_or_value_is_refused_by_its_name(values, message):
    with pytest.raises(SettingError, match=message):
        changed(DEFAULT, values)


def test_built_in_models_are_parameters_and_take_the_place_of_others():
    current = ModelChoice("mine.py:Flat", "", ("mine.py:Flat",))
    values = {"laser_model_type": "beam", "sigma_hit": 0.1}
    result, choice = with_values_and_models(DEFAULT, current, values)
    assert choice == ModelChoice("", "", ("mine.py:Flat",))
    assert (result.sensor.laser_model_type, result.sensor.sigma_hit) == ("beam", 0.1)
    assert with_values_and_models(DEFAULT, current, {"sigma_hit": 0.1})[1] == current
    with pytest.raises(SettingError, match="laser_model_type is 'best'; valid are"):
        with_values_and_models(DEFAULT, current, {"laser_model_type": "best"})
    with pytest.raises(SettingError, match=r"no model gone\.py:X; of your own .* mine\.py:Flat"):
        with_values_and_models(DEFAULT, current, {"laser_model_type": "gone.py:X"})


def test_a_model_of_the_users_own_is_a_choice_and_no_parameter():
    offer = ModelChoice(sensors=("mine.py:Mine",))
    values = {"laser_model_type": "mine.py:Mine", "max_particles": 700}
    result, choice = with_values_and_models(DEFAULT, offer, values)
    assert choice.sensor == "mine.py:Mine"
    assert result == changed(DEFAULT, {"max_particles": 700})
